// Runs a script so that what it throws is reported by itself, and does not end the batch of messages that it came in.
({script}) => {
  try { script(); } catch (problem) { setTimeout(() => { throw problem; }); }
}
