// Gives each slider and number field the name of its row, and the stage one of its own, for whoever hears the page.
({stage}) => {
  const lab = window.observerLabAria ??= {};
  lab.stage = stage;
  lab.write ??= () => {
    lab.waits = false;
    for (const each of document.querySelectorAll('[role=slider]:not([data-named]),input:not([data-named],[type=hidden])')) {
      if (each.labels?.length || each.getAttribute('aria-label')) continue;
      let row = each.parentElement;
      for (let up = 0; row && up < 8 && !row.querySelector('label')?.textContent.trim(); up += 1) row = row.parentElement;
      const name = row?.querySelector('label')?.textContent.trim();
      if (name) { each.setAttribute('aria-label', name); each.dataset.named = ''; }
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
