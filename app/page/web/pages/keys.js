// Keeps from viser's camera the keys that mean something else here: the arrows of a widget, the letters of commands.
() => {
  if (window.observerLabKeys) return;
  window.observerLabKeys = true;
  document.documentElement.addEventListener('keydown', event => {
    const walks = /^Key[WASDQE]$/.test(event.code), turns = event.code.startsWith('Arrow');
    const widget = event.target !== document.body && event.target?.tagName !== 'CANVAS';
    if (walks || (turns && widget)) event.stopPropagation();
  });
}
