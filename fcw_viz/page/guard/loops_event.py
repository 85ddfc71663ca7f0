"""What threads draw on a page while viser's loop sends it.

viser sets an asyncio event of new messages in whatever thread drew something, and then has its loop set it,
too. The former goes through those who wait for the event while the loop may change them: now and then drawing
ended half done, in `deque mutated during iteration`. The latter is enough.
"""

import asyncio

import viser


class LoopsEvent(asyncio.Event):
    """An event that is set in its loop alone; elsewhere that does nothing."""

    def set(self) -> None:
        """Wake those who wait, in the loop."""
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            return
        super().set()


async def wake_in_loop(client: viser.ClientHandle) -> None:
    """Have a tab that has come told of what is drawn by the loop alone."""
    # Some may wait for the event already: it stays the same one.
    client._websock_connection.get_message_buffer().message_event.__class__ = LoopsEvent
