"""One browser tab: mailbox, worker, history and state; it knows a screen only as a View protocol."""
