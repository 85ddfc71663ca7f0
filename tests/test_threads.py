"""OpenCV's own threads are put aside and come back; only cores that we may run on are counted."""

import os
from contextlib import ExitStack

import cv2
import pytest

from fcw.threads import available_cores, one_opencv_thread


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="the system does not tell")
def test_cores_that_others_have_are_not_counted():
    before = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(before)})
        assert available_cores() == 1
    finally:
        os.sched_setaffinity(0, before)
    assert available_cores() == len(before)


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


def test_there_is_one_thread_until_the_last_who_asked_for_it_has_ended():
    original = cv2.getNumThreads()
    try:
        cv2.setNumThreads(2)
        with ExitStack() as second:
            with one_opencv_thread():
                second.enter_context(one_opencv_thread())
            assert cv2.getNumThreads() == 1
        assert cv2.getNumThreads() == 2
    finally:
        cv2.setNumThreads(original)
