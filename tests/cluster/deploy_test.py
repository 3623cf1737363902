#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What deploy/ and packaging/ say, as far as Debian's programs can check it: neither Docker nor Kubernetes runs here."""
import functools
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import unittest
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
DEPLOY = ROOT / "deploy"
HAPROXY = "/usr/sbin/haproxy"
OPTION = re.compile(r"^--([a-z-]+)")


@functools.cache
def options_of(command):
    """The options that a command's source adds."""
    text = (ROOT / "cli/commands" / f"{command}.cc").read_text(encoding="utf-8")
    shared = {"threads"} if "AddThreadsFlag(" in text else set()  # of cli/commands/build_sources.cc
    return set(re.findall(r'"--([a-z-]+)[",]', text)) | shared


def documents(name):
    with open(DEPLOY / "kubernetes" / f"{name}.yaml", encoding="utf-8") as file:
        return [document for document in yaml.safe_load_all(file) if document]


def manifests():
    return [each for name in ("servers", "balancer", "workers") for each in documents(name)]


def pods():
    """(name, pod) of each workload."""
    return [(each["metadata"]["name"], each["spec"]["template"]["spec"]) for each in manifests()
            if each["kind"] in ("Deployment", "StatefulSet")]


def flags_of(container):
    """What the options of a container say, by their names."""
    return dict(argument[2:].split("=", 1) for argument in container["args"] if "=" in argument)


class Commands(unittest.TestCase):
    def check(self, arguments):
        command, *rest = arguments
        self.assertTrue((ROOT / "cli/commands" / f"{command}.cc").exists(), command)
        for argument in rest:
            found = OPTION.match(argument)
            if found:
                self.assertIn(found[1], options_of(command), command)

    def test_programs_are_started_with_options_that_they_have(self):
        compose = yaml.safe_load((DEPLOY / "compose.yaml").read_text(encoding="utf-8"))
        for service in compose["services"].values():
            if service.get("command") and service["command"] != ["--help"]:
                self.check(service["command"])
        for _, pod in pods():
            for container in pod["containers"]:
                if "args" in container:
                    self.check(container["args"])
        for unit in ("waystone-node", "waystone-worker"):
            line = re.search(r"/usr/bin/waystone (.+)", (ROOT / f"packaging/{unit}.service").read_text())[1]
            default = re.search(r"^WAYSTONE_\w+=(.*)", (ROOT / f"packaging/{unit}.default").read_text(), re.MULTILINE)[1]
            self.check([word for word in (line + " " + default).split() if not word.startswith("$")])


class Compose(unittest.TestCase):
    def setUp(self):
        self.compose = yaml.safe_load((DEPLOY / "compose.yaml").read_text(encoding="utf-8"))

    def test_what_services_name_is_there(self):
        services = self.compose["services"]
        for name, service in services.items():
            for other in service.get("depends_on", []):
                self.assertIn(other, services, name)
            for secret in service.get("secrets", []):
                self.assertIn(secret, self.compose["secrets"], name)
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if not source.startswith((".", "/")):
                    self.assertIn(source, self.compose["volumes"], name)

    def test_ours_write_to_volumes_alone_and_servers_share_no_cache(self):
        services = self.compose["services"]
        caches = []
        for name, service in services.items():
            if service["image"] != "waystone":
                continue
            self.assertTrue(service["read_only"], name)
            self.assertEqual(service["cap_drop"], ["ALL"], name)
            caches += [volume for volume in service["volumes"] if volume.endswith(":/cache")]
        self.assertEqual(len(set(caches)), 3)

    def test_the_balancer_knows_the_servers(self):
        environment = self.compose["services"]["balancer"]["environment"]
        named = {value.split(":")[0] for key, value in environment.items() if key.startswith("WAYSTONE_SERVER")}
        self.assertEqual(named, {name for name in self.compose["services"] if name.startswith("server")})


class Dockerfile(unittest.TestCase):
    def setUp(self):
        self.lines = (DEPLOY / "Dockerfile").read_text(encoding="utf-8").replace("\\\n", " ").splitlines()

    def test_what_is_copied_is_there(self):
        for line in self.lines:
            if line.startswith("COPY ") and "--from" not in line:
                for source in line.split()[1:-1]:
                    self.assertTrue((ROOT / source).exists(), source)

    def test_it_ends_as_a_user_without_rights(self):
        last = [line for line in self.lines if line.startswith("USER ")][-1]
        self.assertNotIn(last.split()[1].split(":")[0], ("root", "0"))
        self.assertLess(self.lines.index(last), self.lines.index('ENTRYPOINT ["/usr/bin/waystone"]'))
        self.assertTrue(any(line.startswith("HEALTHCHECK ") for line in self.lines))

    def test_the_package_is_where_it_is_taken_from(self):
        packaging = (ROOT / "packaging/CMakeLists.txt").read_text(encoding="utf-8")
        self.assertIn("CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/package", packaging)
        self.assertTrue(any("build/release/package/waystone_*.deb" in line for line in self.lines))


class Kubernetes(unittest.TestCase):
    def test_objects_are_complete(self):
        for each in manifests():
            self.assertIn("/" if each["kind"] not in ("Service",) else "v1", each["apiVersion"])
            self.assertEqual(each["metadata"]["namespace"], "waystone")
        kinds = [each["kind"] for each in manifests()]
        self.assertEqual(kinds.count("PodDisruptionBudget"), 2)

    def test_selectors_find_their_pods(self):
        labels = [each["spec"]["template"]["metadata"]["labels"] for each in manifests() if "template" in each["spec"]]
        for each in manifests():
            selector = each["spec"]["selector"]
            selector = selector.get("matchLabels", selector)
            self.assertTrue(any(selector.items() <= label.items() for label in labels), each["metadata"]["name"])

    def test_volumes_ports_and_resources_are_given(self):
        for name, pod in pods():
            self.assertTrue(pod["securityContext"]["runAsNonRoot"], name)
            volumes = {volume["name"] for volume in pod.get("volumes", [])}
            if name == "waystone":
                volumes |= {claim["metadata"]["name"] for claim in documents("servers")[1]["spec"]["volumeClaimTemplates"]}
            for container in pod["containers"]:
                self.assertEqual({mount["name"] for mount in container["volumeMounts"]}, volumes, name)
                self.assertTrue(container["securityContext"]["readOnlyRootFilesystem"], name)
                self.assertIn("memory", container["resources"]["limits"], name)
                ports = {port["name"] for port in container.get("ports", [])}
                for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
                    where = container.get(probe, {})
                    port = where.get("httpGet", where.get("tcpSocket", {})).get("port")
                    self.assertIn(port, ports | {None}, name)

    def test_probes_ask_for_paths_that_are_served(self):
        contract = yaml.safe_load((ROOT / "clients/openapi.yaml").read_text(encoding="utf-8"))
        for name, pod in pods():
            for container in pod["containers"]:
                for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
                    path = container.get(probe, {}).get("httpGet", {}).get("path")
                    self.assertIn(path, {*contract["paths"], None}, name)

    def test_the_balancer_lists_all_servers(self):
        servers = next(each for each in manifests() if each["kind"] == "StatefulSet")
        environment = {each["name"]: each["value"] for each in dict(pods())["waystone-balancer"]["containers"][0]["env"]}
        listed = [value for name, value in environment.items() if name.startswith("WAYSTONE_SERVER_")]
        meta = servers["metadata"]
        self.assertEqual(listed, [f"{meta['name']}-{i}.{servers['spec']['serviceName']}.{meta['namespace']}"
                                  ".svc.cluster.local:8080" for i in range(servers["spec"]["replicas"])])

    def test_the_cache_fits_its_volume_and_the_maps_the_memory(self):
        spec = next(each for each in manifests() if each["kind"] == "StatefulSet")["spec"]
        container = spec["template"]["spec"]["containers"][0]
        flags = flags_of(container)
        storage = spec["volumeClaimTemplates"][0]["spec"]["resources"]["requests"]["storage"]
        self.assertLess(int(flags["cache-size"][:-1]) * 1e9, int(storage[:-2]) * 2**30)
        memory = int(flags["memory"][:-1]) * 1e9
        threads = int(flags["threads"])
        # What docs/operating.md says: maps, of which some take a third more than they count, the coarse index,
        # and queries.
        taken = memory * (1 + 1 / 3 + 1 / 4) + threads * 305e6 + 1.1e9
        self.assertGreater(int(container["resources"]["limits"]["memory"][:-2]) * 2**30, taken)

    def test_programs_take_the_threads_that_they_request_cores_for(self):
        ours = [container for _, pod in pods() for container in pod["containers"] if "args" in container]
        self.assertEqual(len(ours), 2)  # servers and workers
        for container in ours:
            self.assertEqual(flags_of(container)["threads"], container["resources"]["requests"]["cpu"], container["name"])

    def test_nothing_scrapes_servers_without_their_token(self):
        server = next(each for each in manifests() if each["kind"] == "StatefulSet")["spec"]["template"]
        self.assertIn("token-file", flags_of(server["spec"]["containers"][0]))
        self.assertNotIn("prometheus.io/scrape", server["metadata"].get("annotations", {}))


class Programs(unittest.TestCase):
    @unittest.skipUnless(Path(HAPROXY).exists(), "HAProxy isn't installed")
    def test_haproxy_takes_its_configuration(self):
        for variables in ({}, {"WAYSTONE_BIND": "*:8000", "WAYSTONE_LOG": "stdout", "WAYSTONE_SERVER_1": "localhost:8080"}):
            said = subprocess.run([HAPROXY, "-c", "-f", DEPLOY / "haproxy.cfg"], env={**os.environ, **variables},
                                  capture_output=True, text=True, check=False)
            self.assertEqual(said.returncode, 0, said.stderr)
            self.assertNotIn("WARNING", said.stderr)

    @unittest.skipUnless(Path(HAPROXY).exists(), "HAProxy isn't installed")
    def test_haproxy_takes_the_lines_for_starting_it_as_root(self):
        text = (DEPLOY / "haproxy.cfg").read_text(encoding="utf-8")
        text, lines = re.subn(r"# (user|group) haproxy", r"\1 root", text)
        self.assertEqual(lines, 2)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "haproxy.cfg"
            path.write_text(text, encoding="utf-8")
            said = subprocess.run([HAPROXY, "-c", "-f", path], capture_output=True, text=True, check=False)
        self.assertEqual(said.returncode, 0, said.stderr)

    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd-analyze isn't installed")
    def test_systemd_takes_the_units(self):
        with tempfile.TemporaryDirectory() as folder:
            for unit in ("waystone-node", "waystone-worker"):
                text = (ROOT / f"packaging/{unit}.service").read_text(encoding="utf-8")
                path = Path(folder) / f"{unit}.service"

                def ours(written, path=path, unit=unit):
                    path.write_text(written, encoding="utf-8")
                    said = subprocess.run(["systemd-analyze", "verify", "--man=no", path], capture_output=True,
                                          text=True, check=False)
                    return [line for line in said.stderr.splitlines() if unit in line]

                text = text.replace("/usr/bin/waystone", "/usr/bin/true")
                if not ours(text + "\n[Service]\nNonsense=yes\n"):
                    self.skipTest("systemd-analyze finds nothing here")
                self.assertEqual(ours(text), [])

    def test_the_health_check_tells_ready_servers_from_others(self):
        class Answer(BaseHTTPRequestHandler):
            status = 200

            def do_GET(self):
                self.send_response(Answer.status if self.path == "/readyz" else 404)
                self.end_headers()

            def log_message(self, *_):
                pass

        with HTTPServer(("127.0.0.1", 0), Answer) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            check = [DEPLOY / "healthcheck.sh", str(server.server_port)]
            self.assertEqual(subprocess.run(check, check=False).returncode, 0)
            Answer.status = 503
            self.assertEqual(subprocess.run(check, check=False).returncode, 1)
            server.shutdown()
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            check = [DEPLOY / "healthcheck.sh", str(free.getsockname()[1])]
            self.assertEqual(subprocess.run(check, check=False, capture_output=True).returncode, 1)


if __name__ == "__main__":
    result = unittest.main(exit=False).result
    sys.exit(1 if not result.wasSuccessful() else 77 if result.skipped else 0)
