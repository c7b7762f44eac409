// Talking to the server: the token, JSON requests, and replies that come line by line (NDJSON).
// May be changed: nothing about whom the page talks to. It asks its own origin only, with the token in a header.

import { ApiError } from "./api_error.js";

const KEY = "nonsmooth-workbench-token";

/** Takes the token out of the address bar into this tab's own storage, so that a copied address holds none. */
export function takeToken() {
  const here = new URL(window.location.href);
  const given = here.searchParams.get("token");
  if (given) {
    window.sessionStorage.setItem(KEY, given);
    here.searchParams.delete("token");
    window.history.replaceState(null, "", here.pathname + here.search + here.hash);
  }
  return window.sessionStorage.getItem(KEY) ?? "";
}

export class Api {
  constructor(token) {
    this.token = token;
  }

  /** Another token, typed by the user after a restart. */
  use(token) {
    this.token = token;
    window.sessionStorage.setItem(KEY, token);
  }

  async #send(path, body, signal) {
    const headers = { Authorization: `Bearer ${this.token}` };
    const options = { headers, signal, cache: "no-store", credentials: "omit" };
    if (body !== undefined) {
      headers["Content-Type"] = "application/json";
      Object.assign(options, { method: "POST", body: JSON.stringify(body) });
    }
    let response;
    try {
      response = await fetch(path, options);
    } catch (error) {
      if (error.name === "AbortError") throw error;
      throw new ApiError("lost", "the workbench's server does not answer");
    }
    if (response.ok) return response;
    if (response.status === 401 || response.status === 403) throw new ApiError("token", "the server does not know this page's token");
    const { error, key } = await refusal(response);
    throw new ApiError(response.status === 503 ? "busy" : "refused", error, key ?? null);
  }

  /** A reply in one piece; a reply `{"error"}` is raised. */
  async json(path, body, signal) {
    const reply = await (await this.#send(path, body, signal)).json();
    if (reply.error) throw new ApiError("refused", reply.error, reply.key ?? null);
    return reply;
  }

  /** Calls `take` with every line of the reply as it comes. */
  async lines(path, body, take, signal) {
    const response = await this.#send(path, body, signal);
    const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
    let rest = "";
    try {
      for (;;) {
        const { value, done } = await reader.read();
        if (done) break;
        const parts = (rest + value).split("\n");
        rest = parts.pop();
        for (const line of parts) if (line) take(JSON.parse(line));
      }
    } catch (error) {
      if (error.name === "AbortError") throw error;
      throw new ApiError("lost", "the connection to the workbench's server broke off");
    }
  }

  /** A file: its content and the name that the server gives it. */
  async file(path, body) {
    const response = await this.#send(path, body);
    const named = /filename="?([^";]+)"?/.exec(response.headers.get("Content-Disposition") ?? "");
    return { blob: await response.blob(), name: named ? named[1] : "scene" };
  }
}

async function refusal(response) {
  try {
    return await response.json();
  } catch {
    return { error: `the server refused the request (${response.status})` };
  }
}
