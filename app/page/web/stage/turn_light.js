// Casts shadows, or no longer, and keeps that for the next time.
() => {
  window.observerLabLight?.turn();
}
