// Puts the state that is shown into the address bar.
({token, lesson, asked}) => {
  window.observerLabAddress?.show(token, lesson, asked);
}
