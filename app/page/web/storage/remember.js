// Keeps what a tab wrote: for this tab alone, through a reload; and for every later tab, beside what others have done meanwhile.
// A browser without storage, or with a full one, keeps nothing.
({key, text, most, answered}) => {
  const lab = window.observerLabKept ??= {}, own = window.observerLabAddress?.own(key) ?? key;
  const desk = written => JSON.stringify(written);
  try {
    sessionStorage.setItem(own, text);
    window.observerLabLine?.answered(answered);  // what is kept holds these presses: after an outage they are not done again
  } catch (error) { console.warn('not kept', error); }
  try {
    const mine = JSON.parse(text), all = JSON.parse(localStorage.getItem(own) ?? '{}').desks ?? {};
    const changed = Object.entries(mine.desks).filter(([name, written]) => !(name in all) || lab[name] !== desk(written));
    for (const [name, written] of changed) lab[name] = desk(written);
    const desks = Object.entries({...Object.fromEntries(changed), ...Object.fromEntries(Object.entries(all).filter(([name]) =>
      !changed.some(([each]) => each === name)))});
    let whole = JSON.stringify({...mine, desks: Object.fromEntries(desks)});
    while (desks.length && new Blob([whole]).size > most) {
      desks.pop();
      whole = JSON.stringify({...mine, desks: Object.fromEntries(desks)});
    }
    localStorage.setItem(own, whole);
  } catch (error) { console.warn('not kept for other tabs', error); }
}
