// What can go wrong with a request: of the server (api.js), or of the kernel of a notebook (kernel.js).
// May be changed: nothing. Who shows errors is in notices.js and field.js.

/** `kind` is "lost" (no server), "busy", "token" (unknown) or "refused" (the request itself). */
export class ApiError extends Error {
  constructor(kind, message, key = null) {
    super(message);
    this.kind = kind;
    this.key = key;
  }
}
