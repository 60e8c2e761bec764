"""Run one browser tab: mailbox, worker thread, history and state, behind a View protocol."""
