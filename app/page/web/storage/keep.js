// While a page is laid out anew for a language, a theme or a size of print, what a hand has opened or closed in the lesson's column
// stays so, the figures' tab stays chosen, and each column stays where it was scrolled to. Folders and tabs are told apart by their
// place, which has no language.
({lesson, large}) => {
  const viser = window.observerLabViser, {column: COLUMN, view: VIEW, folder: FOLDER, folderHead: HEAD, tab: TAB} = viser.parts;
  const lab = window.observerLabKeep ??= {lesson: '', hand: {}, run: 0}, run = lab.run += 1, STEP = 60;  // ms
  const MOST = 500, STILL = 25;  // looks, not ms: a busy page looks seldom
  const asked = () => document.querySelector('.ol-question,.ol-scene'), old = asked(), KNOBS = `div:has(>.ol-part-knobs)+${FOLDER}`;
  const column = () => asked()?.closest(VIEW);
  const figures = () => document.querySelector(`${COLUMN} ${VIEW}`);
  const tabs = () => [...document.querySelectorAll(`${COLUMN} ${TAB}`)];

  const folders = () => {  // name → head; counted from the end, since large print has one folder more at the beginning
    const heads = [...column()?.querySelectorAll(HEAD) ?? []];
    const marks = [...column()?.querySelectorAll('.ol-part-knobs,.ol-part-why,.ol-part-tasks') ?? []];
    const part = head => marks.filter(mark => mark.compareDocumentPosition(head) & Node.DOCUMENT_POSITION_FOLLOWING).length;
    const above = head => head.parentElement.parentElement.closest(FOLDER);
    const group = new Map(heads.map(head => [head, heads.find(other => other.parentElement === above(head)) ?? part(head)]));
    const name = head => {
      const own = group.get(head), mates = heads.filter(other => group.get(other) === own), last = mates.length - mates.indexOf(head);
      const print = typeof own !== 'number' && head.closest(KNOBS) ? large : '';  // which has other knobs behind "more"
      return `${typeof own === 'number' ? own : name(own)}.${last}${print}`;
    };
    return new Map(heads.map(head => [name(head), head]));
  };
  const reasons = () => [...column()?.querySelectorAll('details') ?? []];

  const held = view => {  // what a column holds: name, where it begins and ends
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
    const top = view.getBoundingClientRect().top, all = held(view);
    const [name, begin, end] = all.findLast(each => each[1] <= top + 1) ?? all[0] ?? [];
    return name === undefined ? null : {name, share: (top - begin) / (end - begin)};
  };
  const away = (view, {name, share}) => {  // px that a column is from where it was
    const [, begin, end] = held(view).find(each => each[0] === name) ?? [];
    return begin === undefined ? 0 : begin + share * (end - begin) - view.getBoundingClientRect().top;
  };

  if (!lab.folders) document.addEventListener('click', event => {
    if (event.isTrusted && event.target.closest(TAB)) lab.figure.at = -1;
    const found = [...lab.folders()].find(([, head]) => head.contains(event.target));
    if (found) lab.hand[found[0]] = !viser.isOpen(found[1]);
  }, {capture: true});
  const same = lab.lesson === lesson, told = same ? reasons().map(each => each.open) : [];
  // where the last change has not come to its end, some of what stands is from before it: what was wanted then still is
  const before = same ? tabs() : [], last = same ? lab.figure : null, half = last?.at >= 0 && last.to === null;
  const figure = lab.figure = half ? {...last} : {count: before.length, at: before.findIndex(each => each.ariaSelected === 'true'), to: null};
  const found = () => [[column, place(column())], [figures, place(figures())]].filter(([, at]) => at);
  const scroll = lab.scroll = {wanted: !same ? [] : lab.scroll && !lab.scroll.moved ? lab.scroll.wanted : found(), moved: false};
  if (!same) Object.assign(lab, {lesson, hand: {}});
  if (!same && document.documentElement.dataset.olPart) document.documentElement.dataset.olPart = 'predict';  // on a phone, its question
  lab.folders = folders;

  const done = new Set(), hands = ['wheel', 'pointerdown', 'keydown', 'touchstart'];
  let looks = 0, still = 0, ends = false;
  const mine = event => {  // a hand has the last word; a letter alone moves nothing
    scroll.moved ||= event.isTrusted && (event.type !== 'keydown' || event.key === ' ' || event.key.length > 1);
  };
  hands.forEach(kind => addEventListener(kind, mine, {capture: true, passive: true}));
  const settle = () => {
    if (run !== lab.run || ends || (looks += 1) > MOST) {
      figure.to ??= undefined;  // what did not come is not waited for
      if (run === lab.run) lab.scroll = null;
      hands.forEach(kind => removeEventListener(kind, mine, {capture: true}));
      return;
    }
    setTimeout(settle, STEP);
    if (!asked() || asked() === old || document.querySelector('.ol-mark')?.dataset.stands !== '1') {  // folders may come or go until then
      still = 0;
      return;
    }
    for (const [name, head] of folders()) if (name in lab.hand && !done.has(name)) {
      done.add(name);
      if (viser.isOpen(head) !== lab.hand[name]) head.click();
    }
    const now = tabs();
    const whole = figure.at >= 0 && now.length === figure.count && !now.some(tab => before.includes(tab));  // they come one by one
    if (whole && figure.to !== now[figure.at]) {
      if (now[figure.at].ariaSelected === 'true') figure.to = now[figure.at];
      else viser.openTab(now[figure.at]);
    }
    if (told.length === reasons().length && !scroll.moved) reasons().forEach((each, k) => { each.open ||= told[k]; });
    const by = scroll.moved ? [] : scroll.wanted.map(([view, at]) => (view() ? away(view(), at) : 0));
    const rests = (figure.at < 0 || figure.to) && by.every(each => Math.abs(each) <= 1);
    by.forEach((each, k) => { if (Math.abs(each) > 1) scroll.wanted[k][0]().scrollTop += each; });
    still = rests ? still + 1 : 0;
    ends = still > STILL;
  };
  settle();
}
