// A worker of the page: the program of the page once more, which plays one job beside it. `src/web/worker.rs` starts it and says what the
// messages are.

import start from "./umbrage.js";

/** Says in words why the program stopped where it could not say so itself: without memory it can't even do that. */
function why(error) {
  const isTrap = error instanceof WebAssembly.RuntimeError;
  return isTrap ? `it stopped (${error.message}), as it does when no memory is left: a program in a browser has 4 GB at most` : `${error}`;
}

onmessage = async ({ data: { program, job, parts } }) => {
  try {
    await start({ module_or_path: program });
    // The program has put this function here, and tells by messages what comes of the job.
    umbrage_work(job, parts);
  } catch (error) {
    // After a panic's own message, which comes first, nobody listens to this one.
    postMessage({ failed: why(error) });
  }
};
