// Puts the state that is shown into the address bar.
({token, lesson, asked, answered}) => {
  window.observerLabAddress?.show(token, lesson, asked, answered);
}
