"""Processes that end with the one that started them, however that ended."""

import os
import threading
import time

CHECK_SECONDS = 0.5


def end_with_parent() -> None:
    """End this process soon after its parent is gone: work that nobody waits for must not outlive a killed build."""
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(CHECK_SECONDS)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
