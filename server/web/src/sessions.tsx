// SPDX-License-Identifier: Apache-2.0
// The history of a map: what each build put into it, and parts that show nothing in common.
import type { MapSummary } from "./api";
import { counted } from "./words";

const namesOf = (map: MapSummary, ids: number[]) =>
  ids.map((id) => `${map.sequences.find((s) => s.id === id)?.name} (${id})`).join(", ");

const seconds = (s: number) => s.toLocaleString("en", { maximumFractionDigits: 1 });

const spanOf = ({ from_s, to_s }: MapSummary["sessions"][number]) =>
  from_s === null || to_s === null ? "" : `${seconds(from_s)} to ${seconds(to_s)}`;

export function Sessions({ map }: { map: MapSummary }) {
  if (map.sessions.length < 2 && map.parts.length < 2) return null;
  const timed = map.sessions.some((session) => session.from_s !== null);
  const panoramas = map.sessions.some((session) => session.panoramas > 0);
  return (
    <section>
      <h2>Sessions</h2>
      {map.parts.length > 1 && (
        <p class="failure" role="note">
          The map has {counted(map.parts.length, "part")} that have no views in common; add a walk that leads from
          one to another: {map.parts.map((part) => namesOf(map, part)).join(" · ")}.
        </p>
      )}
      <div class="scroll" tabIndex={0} role="region" aria-label="Sessions">
        <table>
          <thead>
            <tr><th scope="col">Session</th><th scope="col">Sequences</th><th scope="col">Keyframes</th>
              {panoramas && <th scope="col">Panoramas</th>}
              {timed && <th scope="col">Time, s</th>}<th scope="col">Built with</th><th scope="col">Version</th></tr>
          </thead>
          <tbody>
            {map.sessions.map((session, i) => (
              <tr key={i}>
                <th scope="row">{session.name}</th>
                <td>{namesOf(map, session.sequences)}</td>
                <td class="number">{session.keyframes.toLocaleString("en")}</td>
                {panoramas && <td class="number">{session.panoramas.toLocaleString("en")}</td>}
                {timed && <td>{spanOf(session)}</td>}
                <td>{session.program}</td>
                <td>{session.version ? <code title={session.version}>{session.version.slice(0, 15)}</code> : "added walk"}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
