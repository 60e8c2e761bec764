// A sentence that is pressed answers for the widget that it names: viser's buttons hold plain words, no mathematics.
() => {
  if (window.observerLabOptions) return;
  window.observerLabOptions = true;
  document.addEventListener('click', event => {
    const option = event.target?.closest?.('button[data-to]:enabled');
    if (!option || option.disabled) return;
    window.__viserMutable.sendMessage({type: 'GuiUpdateMessage', uuid: option.dataset.to, updates: {value: option.dataset.value}});
  });
}
