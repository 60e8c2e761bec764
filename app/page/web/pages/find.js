// Puts the focus on a knob by the words beside it, and brings it into view; a folder in which it stands is opened first.
({label, folder}) => {
  const viser = window.observerLabViser, end = performance.now() + 5000;
  const seek = () => {
    const name = [...document.querySelectorAll('label')].find(each => each.checkVisibility() && each.textContent.trim() === label);
    const row = name?.closest(viser.parts.row), widget = row?.querySelector('[role=slider],input:not([type=hidden])');
    if (widget) {
      document.documentElement.dataset.olPart = 'knobs';  // on a phone, which shows one part at a time
      row.scrollIntoView({block: 'center'});
      widget.focus();
      return;
    }
    const head = [...document.querySelectorAll(viser.parts.folderHead)].find(each => each.textContent.trim() === folder);
    if (head && !viser.isOpen(head)) head.click();
    if (performance.now() < end) setTimeout(seek, 150);
  };
  setTimeout(seek, 50);  // once the palette has closed and given the focus back
}
