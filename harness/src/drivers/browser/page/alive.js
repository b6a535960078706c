// A thread that says that the page is alive, while a draw blocks the page's own.
"use strict";

(async () => {
  for (;;) {
    await fetch("alive", { method: "POST" });
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
})();
