// Recognise a frame, and train while telling how far it is.

import createClient from "openapi-fetch";
import type { components, paths } from "../landmarkd";

type Recognition = components["schemas"]["RecognitionBody"];
type Job = components["schemas"]["JobBody"];

/** What the service refused; `code` is for programs, `detail` says what to do. */
export class Refusal extends Error {
  constructor(readonly problem: components["schemas"]["Problem"]) {
    super(`${problem.status} ${problem.code}: ${problem.detail}`);
  }
}

/** A client of the service at an address, with a key if it asks for one. */
export function service(url: string, key?: string) {
  return createClient<paths>({ baseUrl: url, headers: key === undefined ? {} : { Authorization: `Bearer ${key}` } });
}

type Service = ReturnType<typeof service>;

/** Ask what a picture shows. */
export async function recognise(service: Service, database: string, picture: Blob): Promise<Recognition> {
  const { data, error } = await service.POST("/v1/databases/{database}/recognitions", {
    params: { path: { database } },
    headers: { "Content-Type": "application/octet-stream", Accept: "application/json" },
    body: picture,
    bodySerializer: (bytes) => bytes,
    parseAs: "json",
  });
  if (error !== undefined) throw new Refusal(error);
  if (!("digest" in data)) throw new Error("a picture came instead of JSON");
  return data;
}

/** For people: one line. */
export function line(answer: Recognition): string {
  if (!answer.decision) return "nothing known";
  const where = `${answer.decision.label} (${answer.decision.confidence?.toFixed(2) ?? "not calibrated"})`;
  if (answer.kind === "objects") return answer.pose?.reliable ? `${where}, turned by ${answer.pose.turn_deg}°` : where;
  const placement = answer.votes[0]?.placement;
  return placement ? `${where} at ${placement.x_px}, ${placement.y_px}` : where;
}

/** Train, and follow the job to its end. */
export async function train(service: Service, database: string, tell: (job: Job) => void): Promise<void> {
  const { data, error } = await service.POST("/v1/databases/{database}/trainings", {
    params: { path: { database } },
    body: { promote: "if_not_worse" },
  });
  if (error !== undefined) throw new Refusal(error);
  // Asked for again and again: an EventSource can't send a key.
  for (let job: Job = data; ; ) {
    tell(job);
    if (job.state === "succeeded") return;
    if (job.state === "failed" || job.state === "cancelled") throw new Error(job.problem?.detail ?? job.state);
    await new Promise((wake) => setTimeout(wake, 500));
    const answer = await service.GET("/v1/jobs/{id}", { params: { path: { id: data.id } } });
    if (answer.error !== undefined) throw new Refusal(answer.error);
    job = answer.data;
  }
}
