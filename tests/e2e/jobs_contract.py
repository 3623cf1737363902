#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""jobs_contract.py URL OPENAPI: holds a server with jobs to the contract's routes of jobs.

Validates the list, and each of its jobs with its details, against clients/openapi.yaml; there must be one.
"""
import json
import sys
import urllib.request

import jsonschema
import yaml

URL, OPENAPI = sys.argv[1:]
with open(OPENAPI, encoding="utf-8") as file:
    CONTRACT = yaml.safe_load(file)
RESOLVER = jsonschema.RefResolver.from_schema(CONTRACT)


def get(path, schema):
    with urllib.request.urlopen(URL + path, timeout=30) as response:
        value = json.load(response)
    wanted = CONTRACT["components"]["schemas"][schema]
    jsonschema.Draft202012Validator(wanted, resolver=RESOLVER).validate(value)
    return value


jobs = get("/v1/jobs", "JobList")["jobs"]
assert jobs
for job in jobs:
    details = get(f"/v1/jobs/{job['id']}", "JobDetails")
    assert details["log"] and details["steps"], details
assert len(get("/v1/jobs?limit=1", "JobList")["jobs"]) == 1
