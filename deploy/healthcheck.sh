#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# healthcheck.sh [PORT]: whether a server on this machine is ready, without any other program.
exec 3<>"/dev/tcp/127.0.0.1/${1:-8080}" || exit 1
printf 'GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' >&3
read -r -t 3 _ status _ <&3 && [ "$status" = 200 ]
