// Gives each slider and number field the name of its row, and the stage one of its own, for whoever hears the page, which has one main part.
// After an answer the focus goes to its verdict, since the pressed button is gone.
({stage}) => {
  const lab = window.observerLabAria ??= {};
  lab.stage = stage;
  if (!lab.hears) {
    lab.hears = true;
    document.addEventListener('click', event => { lab.answers ||= !!event.target?.closest?.('.ol-card .ol-option'); }, true);
  }
  const toVerdict = () => {
    const told = document.querySelector('.ol-answer:has(.ol-right,.ol-wrong)'), at = document.activeElement;
    if (!lab.answers || !told) return;
    lab.answers = false;
    if (at && at !== document.body && !at.matches(':disabled')) return;  // a hand is elsewhere by now
    told.tabIndex = -1;
    told.focus({preventScroll: true});
  };
  lab.write ??= () => {
    lab.waits = false;
    document.getElementById('root')?.setAttribute('role', 'main');
    toVerdict();
    for (const each of document.querySelectorAll('[role=slider]:not([data-named]),input:not([data-named],[type=hidden])')) {
      if (each.labels?.length || each.getAttribute('aria-label')) continue;
      let row = each.parentElement;
      for (let up = 0; row && up < 8 && !row.querySelector('label')?.textContent.trim(); up += 1) row = row.parentElement;
      const name = row?.querySelector('label')?.textContent.trim();
      if (name) { each.setAttribute('aria-label', name); each.dataset.named = ''; }
    }
    for (const each of document.querySelectorAll('.ol-formula')) {  // one that is wider than its place is scrolled with the arrow keys
      if (each.scrollWidth > each.clientWidth + 1) each.tabIndex = 0; else each.removeAttribute('tabindex');
    }
    const canvas = document.querySelector(window.observerLabViser.parts.stage);
    if (canvas && canvas.getAttribute('aria-label') !== lab.stage) {
      canvas.setAttribute('role', 'img');
      canvas.setAttribute('aria-label', lab.stage);
    }
  };
  lab.watch ??= new MutationObserver(() => { if (!lab.waits) { lab.waits = true; setTimeout(lab.write, 50); } });
  lab.watch.observe(document.body, {childList: true, subtree: true});
  lab.write();
}
