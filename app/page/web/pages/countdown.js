// Counts down, from when this page first sees it, the time that the class has to discuss.
() => {
  if (window.observerLabCountdown) return;
  const begun = {};
  const pages = () => [document, window.observerLabNotes?.view?.document].filter(Boolean);
  const write = () => pages().flatMap(page => [...page.querySelectorAll('[data-talk]')]).forEach(each => {
    const {talk, most} = each.dataset, now = performance.now(), left = Math.max(Math.round(most - (now - (begun[talk] ??= now)) / 1000), 0);
    const said = `${Math.floor(left / 60)}:${String(left % 60).padStart(2, '0')}`;
    if (each.textContent !== said) each.textContent = said;
  });
  window.observerLabCountdown = setInterval(write, 250);
}
