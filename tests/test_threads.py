"""OpenCV's own threads are put aside and come back."""

import cv2
import pytest

from fcw.threads import one_opencv_thread


@pytest.mark.parametrize("before", [1, 2])
def test_the_number_of_threads_is_as_before_also_after_a_fault(before: int):
    original = cv2.getNumThreads()
    try:
        cv2.setNumThreads(before)
        with one_opencv_thread():
            assert cv2.getNumThreads() == 1
        assert cv2.getNumThreads() == before
        with pytest.raises(KeyError), one_opencv_thread():
            raise KeyError
        assert cv2.getNumThreads() == before
    finally:
        cv2.setNumThreads(original)
