"""Files out of clones of public repositories."""

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray


class Repository:
    """Reads files out of a bare clone, without a work tree."""

    def __init__(self, clones: Path, name: str) -> None:
        self.git = clones / name.replace("/", "+")
        if not self.git.exists():
            command = ["git", "clone", "--bare", f"https://github.com/{name}", str(self.git)]
            subprocess.run(command, check=True)

    @contextmanager
    def files(self, commit: str = "HEAD") -> Iterator["Files"]:
        """Those of a commit."""
        command = ["git", "--git-dir", str(self.git), "cat-file", "--batch"]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
            yield Files(process, commit)
            if process.stdin is not None:
                process.stdin.close()


@dataclass(frozen=True, slots=True)
class Files:
    """Files of a commit, one after the other."""

    process: "subprocess.Popen[bytes]"
    commit: str

    def content(self, path: str) -> bytes:
        """Of a file.

        Raises:
            FileNotFoundError: there is none of that path.
        """
        asked, answered = self.process.stdin, self.process.stdout
        assert asked is not None
        assert answered is not None
        asked.write(f"{self.commit}:{path}\n".encode())
        asked.flush()
        head = answered.readline().split()
        if head[-1] == b"missing":
            raise FileNotFoundError(path)
        content = answered.read(int(head[2]))
        answered.read(1)
        return content

    def text(self, path: str) -> str:
        """Of a file of text."""
        return self.content(path).decode()

    def picture(self, path: str) -> NDArray[np.uint8]:
        """Of a picture, (height, width, 3) BGR."""
        picture = cv2.imdecode(np.frombuffer(self.content(path), np.uint8), cv2.IMREAD_COLOR)
        assert picture is not None, path
        return np.asarray(picture, np.uint8)
