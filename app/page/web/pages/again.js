// Brings a second question into view when it comes, once the hand has let go of what it moves.
() => {
  if (window.observerLabAgain) return;
  let held = false, due = 0, brought = null;
  const bring = () => {
    due = 0;
    const question = document.querySelector('.ol-again');
    if (!question) brought = null;
    if (!question || held || question === brought) return;
    brought = question;
    question.scrollIntoView({block: 'end', behavior: matchMedia('(prefers-reduced-motion: reduce)').matches ? 'auto' : 'smooth'});
  };
  const later = () => { due ||= setTimeout(bring, 300); };
  addEventListener('pointerdown', () => { held = true; }, {capture: true});
  for (const end of ['pointerup', 'pointercancel']) addEventListener(end, () => { held = false; later(); }, {capture: true});
  window.observerLabAgain = new MutationObserver(later);
  window.observerLabAgain.observe(document.body, {childList: true, subtree: true});
}
