"""What is said where the folder of a recording goes away."""

import pytest
from rerun_drives import HEADER, packet, result

from fcw.errors import UserError
from fcw_viz.rerun.log import RerunSink


def test_of_a_folder_that_was_moved_it_is_not_said_that_the_disk_is_full(tmp_path):
    (tmp_path / "out").mkdir()
    sink = RerunSink(tmp_path / "out" / "drive.rrd")
    sink.open(HEADER)
    sink.write(result(0), [packet(0)])
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    with pytest.raises(UserError, match=r"drive\.rrd: .* \(No such file or directory\); .*moved it") as told:
        sink.close()
    assert "run again, into a folder that nothing else writes to" in str(told.value)
    assert "disk" not in str(told.value)
