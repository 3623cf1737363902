// SPDX-License-Identifier: Apache-2.0
// View: the jobs of the registry, which workers build maps for. It is asked anew while it is shown.
import { useEffect, useState } from "preact/hooks";
import { type Job, listJobs } from "./api";
import { Failure, Waiting } from "./parts";
import { counted } from "./words";

const kPauseMs = 3000;

const whenOf = (time: string | null) =>
  time === null ? "" : new Date(time).toLocaleString("en", { dateStyle: "medium", timeStyle: "short" });

function Progress({ job }: { job: Job }) {
  if (job.frames === null) return <>not started</>;
  const done = Math.min(job.frames_done, job.frames);
  const parts = job.parts > 1 ? `, ${job.parts_done} of ${counted(job.parts, "part")}` : "";
  return (
    <>
      <progress value={done} max={Math.max(1, job.frames)} aria-label={`Frames of job ${job.id}`} />
      <small>{done.toLocaleString("en")} of {counted(job.frames, "frame")}{parts}</small>
    </>
  );
}

function State({ job }: { job: Job }) {
  const outcome = job.state === "done" ? "good" : job.state === "failed" ? "bad" : "";
  return (
    <span class={`outcome ${outcome}`}>
      {job.state}
      {job.version !== null && `, version ${job.version}`}
      {job.reason && <small>{job.reason}</small>}
      {job.workers.map((worker) => (
        <small key={worker.step}>
          {worker.worker}: {worker.kind === "part" ? `part ${worker.step}` : worker.kind}
          {worker.stage && `, ${worker.stage}`}
        </small>
      ))}
    </span>
  );
}

function Table({ jobs }: { jobs: Job[] }) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Jobs">
      <table class="jobs">
        <thead>
          <tr><th scope="col">Job</th><th scope="col">Map</th><th scope="col">State</th>
            <th scope="col">Progress</th><th scope="col">Sources</th><th scope="col">Enqueued</th></tr>
        </thead>
        <tbody>
          {jobs.map((job) => (
            <tr key={job.id}>
              <td class="number">{job.id}</td>
              <th scope="row">{job.name}</th>
              <td><State job={job} /></td>
              <td><Progress job={job} /></td>
              <td>{job.sources.join(", ")}</td>
              <td>{whenOf(job.created_at)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function JobsView() {
  const [jobs, setJobs] = useState<Job[] | null>(null);
  const [error, setError] = useState<string | null>(null);
  useEffect(() => {
    let gone = false;
    let timer = 0;
    const load = async () => {
      try {
        const now = await listJobs();
        if (!gone) setJobs(now);
        if (!gone) setError(null);
      } catch (e) {
        if (!gone) setError((e as Error).message);
      }
      if (!gone) timer = window.setTimeout(load, kPauseMs);
    };
    load();
    return () => {
      gone = true;
      clearTimeout(timer);
    };
  }, []);
  return (
    <>
      <h1>Jobs</h1>
      {error && <Failure error={error} />}
      {!jobs && !error && <Waiting what="the jobs" />}
      {jobs && jobs.length > 0 && <Table jobs={jobs} />}
      {jobs?.length === 0 && (
        <p class="missing">No jobs. <code>waystone enqueue</code> queues a map for a worker (<code>waystone work</code>) to build.</p>
      )}
    </>
  );
}
