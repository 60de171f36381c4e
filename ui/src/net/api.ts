// Requests to the server.

/** An error in words, with a suggestion and the field of the form at fault. */
export class RequestFailed extends Error {
  constructor(
    message: string,
    readonly help = "",
    readonly field = "",
    readonly status = 0,
  ) {
    super(message);
  }
}

/** Read JSON data. */
export function get<T>(path: string): Promise<T> {
  return request<T>(path, {});
}

/** Send JSON data, and read the answer. */
export function post<T>(path: string, body: object): Promise<T> {
  return request<T>(path, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
}

/** Read bytes. */
export async function bytes(path: string): Promise<Uint8Array<ArrayBuffer>> {
  const answer = await call(path, {});
  if (!answer.ok) throw await failure(answer);
  return new Uint8Array(await answer.arrayBuffer());
}

async function request<T>(path: string, init: RequestInit): Promise<T> {
  const answer = await call(path, init);
  if (!answer.ok) throw await failure(answer);
  return (await answer.json()) as T;
}

async function call(path: string, init: RequestInit): Promise<Response> {
  try {
    return await fetch(path, { ...init, credentials: "same-origin" });
  } catch {
    throw new RequestFailed("seoro ui does not answer", "start it again, and open the URL that it prints");
  }
}

async function failure(answer: Response): Promise<RequestFailed> {
  const found = (await answer.json().catch(() => ({}))) as { error?: string; help?: string; field?: string };
  const error = found.error ?? `the server answered with status ${answer.status}`;
  return new RequestFailed(error, found.help, found.field, answer.status);
}

/** What went wrong, for people. */
export function textOf(error: unknown): { error: string; help: string } {
  if (error instanceof RequestFailed) return { error: error.message, help: error.help };
  return { error: error instanceof Error ? error.message : String(error), help: "" };
}
