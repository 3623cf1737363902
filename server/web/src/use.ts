// SPDX-License-Identifier: Apache-2.0
// The hooks that several views use.
import { useEffect, useState } from "preact/hooks";
import { get, holdPicture, pictureAddress, picturesAreFetched } from "./api";

export interface Loaded<T> {
  value: T | null;
  error: string | null;
}

// The answer to a GET, null until it is there. Nothing is asked for a null path.
export function useGet<T>(path: string | null): Loaded<T> {
  const [state, setState] = useState<Loaded<T> & { path: string | null }>({
    path: null,
    value: null,
    error: null,
  });
  useEffect(() => {
    if (!path) return;
    let current = true;
    const keep = (value: T | null, error: string | null) => {
      if (current) setState({ path, value, error });
    };
    get<T>(path).then(
      (value) => keep(value, null),
      (error: Error) => keep(null, error.message),
    );
    return () => {
      current = false;
    };
  }, [path]);
  return state.path === path ? state : { value: null, error: null };
}

// Whether a media query holds, kept up to date.
export function useMedia(query: string): boolean {
  const [holds, setHolds] = useState(() => matchMedia(query).matches);
  useEffect(() => {
    const list = matchMedia(query);
    const update = () => setHolds(list.matches);
    update();
    list.addEventListener("change", update);
    return () => list.removeEventListener("change", update);
  }, [query]);
  return holds;
}

// The address of a map's picture; null until it is there and for none. Others are their own addresses.
export function usePicture(path: string | null): string | null {
  const ofMap = path !== null && path.startsWith("/v1/");
  const fetched = ofMap && picturesAreFetched();
  const [state, setState] = useState<{ path: string; address: string } | null>(null);
  useEffect(() => {
    if (!fetched) return;
    let current = true;
    const { value, release } = holdPicture(path);
    value.then(
      (address) => current && setState({ path, address }),
      () => {}, // stays without a picture
    );
    return () => {
      current = false;
      release();
    };
  }, [path, fetched]);
  if (!fetched) return ofMap ? pictureAddress(path) : path;
  return state?.path === path ? state.address : null;
}
