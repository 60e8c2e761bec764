// Runs before viser's page: of a folder that was never opened nothing is built, which is half of what a lesson's column holds.
() => {
  window.observerLabViser.buildWhenOpened(window.observerLabOpened = {});
}
