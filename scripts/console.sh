# shellcheck shell=bash
# How the scripts speak: one line per step, progress while it takes, details in a log file. To be sourced.

log_file=${log_file:-/dev/null}

say() { printf '%s\n' "bringup: $*"; }

# fail SENTENCE...: the last words of a call that cannot go on
fail() {
  printf '%s\n' "bringup: $1" >&2
  shift
  (($# == 0)) || printf '  %s\n' "$@" >&2
  exit 1
}

# last_log_line: what the running command said last, in one short line
last_log_line() { tail -n 1 "$log_file" 2>/dev/null | tr '\r\t' '  ' | tr -cd '[:print:]' | cut -c 1-70; }

# progress SECONDS TEXT: on a terminal one line that is written over, elsewhere a new line every ten seconds
progress() {
  if [[ -t 1 ]]; then
    printf '\r\033[K  %3d s  %s' "$1" "$2"
  elif (($1 > 0 && $1 % 10 == 0 && $1 != last_progress)); then
    printf '  %3d s  %s\n' "$1" "$2"
  fi
  last_progress=$1
}

# run_step TITLE COMMAND...: runs it with its output in the log, shows that it is alive, and returns its code
run_step() {
  local title=$1 start=$SECONDS last_progress=0 code=0 child
  shift
  say "$title ..."
  printf '\n== %s: %s ==\n' "$title" "$*" >>"$log_file"
  set -m # in a process group of its own, so that an interrupt ends all of it
  "$@" >>"$log_file" 2>&1 </dev/null &
  child=$!
  set +m
  trap 'kill -- "-$child" 2>/dev/null; [[ -t 1 ]] && echo; fail "Interrupted. The next call goes on from here."' INT TERM
  while kill -0 "$child" 2>/dev/null; do
    sleep 0.2
    progress $((SECONDS - start)) "$(last_log_line)"
  done
  wait "$child" || code=$?
  trap - INT TERM
  [[ ! -t 1 ]] || printf '\r\033[K'
  ((code != 0)) || say "$title: done in $((SECONDS - start)) s"
  return "$code"
}
