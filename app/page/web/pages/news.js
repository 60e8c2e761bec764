// Brings a verdict or a second question that has just come into view, clear of the pinned knobs, once the hand has let go. The card of
// another scene begins at its top.
() => {
  if (window.observerLabNews) return;
  const viser = window.observerLabViser, NEWS = '.ol-again,.ol-right,.ol-wrong', GAP = 10;
  let held = false, due = 0, known = null, speaks = '', scene = null;
  const told = () => [...document.querySelectorAll(NEWS)].filter(each => each.checkVisibility() && !each.closest(viser.parts.dialog));
  const words = element => element.textContent.trim();
  const bring = element => {
    const shown = element.matches('.ol-again') ? element.closest(viser.parts.folder) ?? element : element, view = shown.closest(viser.parts.view);
    const pinned = document.querySelector('div:has(>.ol-part-knobs)+[data-ol-folder]');
    if (!view) return;
    const box = shown.getBoundingClientRect(), room = view.getBoundingClientRect();
    let {top, bottom} = room;
    if (pinned && view.contains(pinned) && !pinned.contains(shown) && getComputedStyle(pinned).position === 'sticky') {
      const later = pinned.compareDocumentPosition(shown) & Node.DOCUMENT_POSITION_FOLLOWING, high = pinned.offsetHeight + 2 * GAP;
      if (later) top += high; else bottom -= high;
    }
    let by = box.bottom > bottom - GAP ? box.bottom - bottom + GAP : 0;
    if (box.top - by < top + GAP) by = box.top - top - GAP;
    const calm = matchMedia('(prefers-reduced-motion: reduce)').matches;
    if (by) view.scrollBy({top: by, behavior: calm ? 'auto' : 'smooth'});
  };
  const look = () => {
    due = 0;
    const stands = document.querySelector('.ol-mark')?.dataset.stands === '1', now = told(), tongue = document.documentElement.lang;
    const before = known, fresh = stands && before !== null && tongue === speaks;
    if (held) return;  // looked at again when the hand lets go
    const card = stands ? document.querySelector('.ol-card .ol-scene') : null;
    if (card && scene !== null && scene !== words(card) && tongue === speaks) card.closest(viser.parts.view)?.scrollTo(0, 0);
    if (card) scene = words(card);
    known = stands ? new Set(now.map(words)) : null;
    speaks = tongue;
    const news = fresh ? now.filter(each => !each.matches('.ol-stale') && !before.has(words(each))) : [];
    if (news.length) bring(news.at(-1));
  };
  const later = () => { due ||= setTimeout(look, 200); };
  addEventListener('pointerdown', () => { held = true; }, {capture: true});
  for (const end of ['pointerup', 'pointercancel']) addEventListener(end, () => { held = false; later(); }, {capture: true});
  window.observerLabNews = new MutationObserver(later);
  window.observerLabNews.observe(document.body, {childList: true, subtree: true, characterData: true});
}
