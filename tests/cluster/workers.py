# SPDX-License-Identifier: Apache-2.0
"""Two workers that build a map in parts, one of which is killed while it does so."""
import json

from cluster import Process, until

NAME = "built"
LEASE_S = 3
PATIENCE_S = 600
PART_FRAMES = 20


class Workers:
    def __init__(self, cluster, folder):
        self.cluster = cluster
        self.workers = [
            Process([cluster.program, "work", "--registry", cluster.postgres.url, "--work", folder / f"work{i}",
                     "--lease", LEASE_S, "--retry-after", "0.5", "--threads", "1"], folder / f"worker{i}.log")
            for i in range(2)]

    def enqueue(self, images):
        return json.loads(self.cluster.run(
            "enqueue", images, "--name", NAME, "--registry", self.cluster.postgres.url, "--features", "orb",
            "--every", 4, "--part-frames", PART_FRAMES, "--json"))["id"]

    def job(self, number):
        return json.loads(self.cluster.run("jobs", self.cluster.postgres.url, "--job", number, "--json"))

    def versions(self):
        listed = self.cluster.run("maps", self.cluster.postgres.url, "--name", NAME, "--json")
        return [json.loads(line)["sha256"] for line in listed.splitlines()]

    def build(self, images, findings, kill):
        """A job from the queue to the registry."""
        number = self.enqueue(images)
        if kill:
            begun = until(lambda: len([w for w in self.job(number)["workers"] if w["kind"] == "part"]) == 2, PATIENCE_S)
            findings.promise(begun[0], "two workers don't build parts at the same time")
            self.workers[0].kill()
        done = until(lambda: self.job(number)["state"] in ("done", "failed", "cancelled"), PATIENCE_S, 0.2)
        job = self.job(number)
        findings.promise(done[0] and job["state"] == "done", f"a job is lost: {job['state']}, {job['reason']}")
        outcomes = {}
        for attempt in job["history"]:
            outcomes.setdefault(attempt["step"], []).append(attempt["outcome"])
        twice = {step: of for step, of in outcomes.items() if of.count("done") != 1}
        findings.promise(not twice, f"steps that weren't built exactly once: {twice}")
        return sum(len(of) - 1 for of in outcomes.values())


def check_workers(cluster, images, photo, findings, folder):
    """A job whose worker is killed gives the same map as one that nobody disturbed."""
    workers = Workers(cluster, folder)
    for each in workers.workers:
        each.start()
    try:
        print("-- a worker is killed in a job", flush=True)
        repeated = workers.build(images, findings, True)
        findings.promise(repeated >= 1, "the killed worker's step was given to nobody else")
        findings.count("repeated_steps", "steps of the killed worker that another one did", repeated)
        workers.workers[0].start()
        workers.build(images, findings, False)
        versions = workers.versions()
        findings.promise(len(versions) == 1, f"a job whose worker was killed gave another map: {versions}")
        status, body = cluster.ask("POST", f"/v1/maps/{NAME}/localize", photo, "image/jpeg")
        served = status == 200 and json.loads(body)["map_version"] == versions[-1]
        findings.promise(served, f"the map that was built is served with status {status}")
    finally:
        for each in workers.workers:
            each.stop()
