// Talking to the kernel of a notebook instead of a server: the same requests and replies as api.js, as messages.
// May be changed: nothing about what is asked; conversation.js and operations.js do not know which of both they have.

import { ApiError } from "./api_error.js";

export class Kernel {
  constructor(model) {
    Object.assign(this, { model, count: 0, heard: new Map() });
    this.take = ({ id, message }) => this.heard.get(id)?.(message);
    model.on("msg:custom", this.take);
  }

  close() {
    this.model.off("msg:custom", this.take);
  }

  /** Calls `take` with every line of the reply as it comes. */
  lines(path, body, take, signal) {
    return new Promise((resolve, reject) => {
      const id = (this.count += 1);
      this.heard.set(id, (message) => {
        take(message);
        if (message.stage === "done" || message.stage === "cancelled") resolve(this.heard.delete(id));
      });
      signal?.addEventListener("abort", () => {
        this.heard.delete(id);
        reject(signal.reason);
      });
      this.model.send({ id, path, body });
    });
  }

  /** A reply in one piece; an error is raised. */
  async json(path, body) {
    let reply = {};
    await this.lines(path, body, (message) => {
      if (message.stage !== "done") reply = message;
    });
    if (reply.stage === "error") throw new ApiError("refused", reply.message, reply.key ?? null);
    return reply;
  }
}
