"""A session for the tests of this folder."""

import pytest
from session_helpers import open_session


@pytest.fixture
def session(tmp_path):
    session = open_session(tmp_path)
    yield session
    session.close()
