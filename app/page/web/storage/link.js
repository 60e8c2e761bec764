// Runs before viser's page: shows our name until a lesson stands, and says so for as long as the server does not answer. After that
// each column is scrolled to where it was, and what was being typed stands there again.
({words, language, kept, scrolled}) => {
  const root = document.documentElement, cover = document.createElement('div'), note = document.createElement('div');
  const viser = window.observerLabViser, line = window.observerLabLine, TYPED = 'textarea,.ol-number input', STEP = 60;  // ms
  const STILL = 25, MOST = 333;  // looks, not ms: a busy page looks seldom
  const known = code => words[code] ?? words[language];
  const remembered = () => { try { return sessionStorage.getItem(kept); } catch (error) { return null; } };
  root.lang = known(remembered()) === words[remembered()] ? remembered() : language;
  cover.className = 'ol-cover';
  note.className = 'ol-lost';
  note.hidden = true;
  note.setAttribute('role', 'alert');
  let reason = 'lost', left = null, returning = null;  // what to go back to, and what a column goes back to now
  const speak = () => {
    const said = known(root.lang), name = document.createElement('b'), loading = document.createElement('span');
    name.textContent = said.name;
    loading.textContent = said.loading;
    cover.replaceChildren(name, loading);
    note.textContent = said[reason].replaceAll('{name}', location.hostname);
    note.classList.toggle('ol-rests', reason === 'rests');
  };
  speak();
  root.append(cover, note);
  const all = selector => [...document.querySelectorAll(selector)];
  const leave = () => ({scrolled: all(viser.parts.view).map(view => view.scrollTop), typed: all(TYPED).map(field => field.value),
    opened: all('details').map(part => part.open)});
  const goBack = wanted => {
    const {scrolled, typed, opened} = returning = wanted;
    const hands = ['wheel', 'pointerdown', 'keydown', 'touchstart'];
    let moved = false, still = 0, looks = 0;
    const mine = event => { moved ||= event.isTrusted; };  // a hand has the last word
    hands.forEach(kind => addEventListener(kind, mine, {capture: true, passive: true}));
    const put = (parts, values, set) => { if (parts.length === values.length) parts.forEach((part, k) => set(part, values[k])); };
    const settle = () => {
      if (moved || returning !== wanted || (looks += 1) > MOST || (still += 1) > STILL) {
        if (returning === wanted) returning = null;
        hands.forEach(kind => removeEventListener(kind, mine, {capture: true}));
        return;
      }
      put(all('details'), opened, (part, open) => { part.open ||= open; });
      put(all(TYPED), typed, (field, words) => { field.value ||= words; });
      if (all(viser.parts.view).length !== scrolled.length) still = 0;  // a column is not there yet
      put(all(viser.parts.view), scrolled, (view, top) => {
        if (Math.abs(view.scrollTop - top) <= 1) return;
        view.scrollTop = top;
        still = 0;  // it may not be as long yet as it was
      });
      setTimeout(settle, STEP);
    };
    settle();
  };
  line.onReload = () => {  // a page that is loaded again by itself stands as it stood
    if (document.querySelector('.ol-question,.ol-scene')) sessionStorage.setItem(scrolled, JSON.stringify(left ?? returning ?? leave()));
  };
  const leftBefore = () => {
    try {
      const before = JSON.parse(sessionStorage.getItem(scrolled));
      sessionStorage.removeItem(scrolled);
      return before;
    } catch (error) { return null; }
  };
  let old = null;
  const look = () => {
    const question = document.querySelector('.ol-question,.ol-scene');
    if (!question || question === old) return;
    cover.hidden = true;
    watch.disconnect();
    if (left) goBack(left);
    left = null;
  };
  const watch = new MutationObserver(look);
  const tell = why => {
    reason = why;
    speak();
    note.hidden = false;
  };
  line.onLost = () => tell('lost');
  line.onRest = () => tell('rests');
  line.onAnswer = status => {  // a proxy that rewrites Host lets the page through and not its connection; 401 asks for another token
    tell({401: 'token', 421: 'stranger'}[status] ?? 'lost');
  };
  line.onBack = () => {
    note.hidden = true;
    old = document.querySelector('.ol-question,.ol-scene');  // of the connection before: viser keeps it until the new one speaks
    left = returning ?? left ?? (old ? leave() : leftBefore());  // a second outage may come before the first is made good
    returning = null;
    cover.hidden = false;
    watch.observe(root, {childList: true, subtree: true});
  };
}
