// While a page is laid out anew for a language, a theme or a size of print, what a hand has opened or closed in the lesson's column
// stays so, and each column stays where it was scrolled to. Folders are told apart by their place, which has no language.
({lesson, large}) => {
  const lab = window.observerLabKeep ??= {lesson: '', hand: {}, run: 0}, run = lab.run += 1, STEP = 60, PATIENCE = 4000;
  const asked = () => document.querySelector('.ol-question'), old = asked(), KNOBS = 'div:has(>.ol-part-knobs)+.mantine-Paper-root';
  const column = () => asked()?.closest('[data-scrollarea-viewport]');
  const figures = () => document.querySelector('[data-dock-region=right] [data-scrollarea-viewport]');
  const isOpen = head => head.lastElementChild.matches('[class*="chevron-up"]');

  const folders = () => {  // name → head; counted from the end, since large print has one folder more at the beginning
    const heads = [...column()?.querySelectorAll('.mantine-Paper-root > .mantine-Paper-root') ?? []]
      .filter(head => head.lastElementChild?.matches('svg[class*="chevron"]'));
    const marks = [...column()?.querySelectorAll('.ol-part-knobs,.ol-part-why,.ol-part-tasks') ?? []];
    const part = head => marks.filter(mark => mark.compareDocumentPosition(head) & Node.DOCUMENT_POSITION_FOLLOWING).length;
    const above = head => head.parentElement.parentElement.closest('.mantine-Paper-root');
    const group = new Map(heads.map(head => [head, heads.find(other => other.parentElement === above(head)) ?? part(head)]));
    const name = head => {
      const own = group.get(head), mates = heads.filter(other => group.get(other) === own), last = mates.length - mates.indexOf(head);
      const print = typeof own !== 'number' && head.closest(KNOBS) ? large : '';  // which has other knobs behind "more"
      return `${typeof own === 'number' ? own : name(own)}.${last}${print}`;
    };
    return new Map(heads.map(head => [name(head), head]));
  };
  const reasons = () => [...column()?.querySelectorAll('details') ?? []];

  const stands = view => {  // what a column holds: name, where it begins and ends
    if (view === column()) return [...folders()].filter(([, head]) => head.getClientRects().length && !head.closest(KNOBS)).map(([name, head]) => {
      const {top, bottom} = head.parentElement.getBoundingClientRect();
      return [name, top, bottom];
    });
    let end = view.firstElementChild.getBoundingClientRect().top;
    return [...view.querySelectorAll('.ol-caption[data-figure]')].map(caption => {
      const begin = end;
      end = caption.getBoundingClientRect().bottom;
      return [caption.dataset.figure, begin, end];
    });
  };
  const place = view => {  // what stands at the top of a column, and how much of it is above
    if (!view?.scrollTop) return null;
    const top = view.getBoundingClientRect().top, all = stands(view);
    const [name, begin, end] = all.findLast(each => each[1] <= top + 1) ?? all[0] ?? [];
    return name === undefined ? null : {name, share: (top - begin) / (end - begin)};
  };
  const away = (view, {name, share}) => {  // px that a column is from where it was
    const [, begin, end] = stands(view).find(each => each[0] === name) ?? [];
    return begin === undefined ? 0 : begin + share * (end - begin) - view.getBoundingClientRect().top;
  };

  if (!lab.folders) document.addEventListener('click', event => {
    const found = [...lab.folders()].find(([, head]) => head.contains(event.target));
    if (found) lab.hand[found[0]] = !isOpen(found[1]);
  }, {capture: true});
  const same = lab.lesson === lesson, told = same ? reasons().map(each => each.open) : [];
  const wanted = same ? [[column, place(column())], [figures, place(figures())]].filter(([, at]) => at) : [];
  if (!same) Object.assign(lab, {lesson, hand: {}});
  lab.folders = folders;

  const done = new Set(), hands = ['wheel', 'pointerdown', 'keydown', 'touchstart'], end = performance.now() + PATIENCE;
  let moved = false;  // by a hand, which has the last word
  const mine = () => { moved = true; };
  hands.forEach(kind => addEventListener(kind, mine, {capture: true, passive: true}));
  const settle = () => {
    if (run !== lab.run || performance.now() > end) {
      hands.forEach(kind => removeEventListener(kind, mine, {capture: true}));
      return;
    }
    setTimeout(settle, STEP);
    if (!asked() || asked() === old) return;
    for (const [name, head] of folders()) if (name in lab.hand && !done.has(name)) {
      done.add(name);
      if (isOpen(head) !== lab.hand[name]) head.click();
    }
    if (told.length === reasons().length && !moved) reasons().forEach((each, k) => { each.open ||= told[k]; });
    if (!moved) for (const [view, at] of wanted) {
      const by = view() ? away(view(), at) : 0;
      if (Math.abs(by) > 1) view().scrollTop += by;
    }
  };
  settle();
}
