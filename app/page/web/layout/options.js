// A sentence that is pressed answers for the widget that it names: viser's buttons hold plain words, no mathematics.
() => {
  if (window.observerLabOptions) return;
  window.observerLabOptions = true;
  document.addEventListener('click', event => {
    const option = event.target?.closest?.('button[data-to]:enabled');
    if (!option || option.disabled) return;
    window.observerLabViser.tell(option.dataset.to, option.dataset.value);
  });
}
