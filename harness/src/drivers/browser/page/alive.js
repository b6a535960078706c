// A worker thread that reports that the page is alive, even while a draw blocks the page's main thread.
"use strict";

(async () => {
  for (;;) {
    await fetch("alive", { method: "POST" });
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
})();
