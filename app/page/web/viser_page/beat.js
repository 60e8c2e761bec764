// The server has answered all that a hand had done up to here, and the page keeps the state.
({answered}) => {
  window.observerLabLine?.answered(answered);
}
