// Sends the question that a presenter has typed to the widget that its button names, and empties the field.
() => {
  if (window.observerLabAsk) return;
  window.observerLabAsk = true;
  document.addEventListener('click', event => {
    const pressed = event.target?.closest?.('button[data-asks]'), field = pressed?.parentElement.querySelector('textarea');
    if (!field) return;
    window.observerLabViser.tell(pressed.dataset.asks, `${pressed.dataset.kind}:${field.value}`);
    field.value = '';
  });
}
