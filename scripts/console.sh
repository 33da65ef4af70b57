# shellcheck shell=bash
# The scripts' output: one line per step, its progress, details in a log file. Other scripts source this file.

log_file=${log_file:-/dev/null}

say() { printf '%s\n' "bringup: $*"; }

# fail SENTENCE...: prints why the call cannot go on, and ends it
fail() {
  printf '%s\n' "bringup: $1" >&2
  shift
  (($# == 0)) || printf '  %s\n' "$@" >&2
  exit 1
}

# last_line FILE: prints the last output of a running command as a short line
last_line() { tail -n 1 "$1" 2>/dev/null | tr '\r\t' '  ' | tr -cd '[:print:]' | cut -c 1-70; }

# megabytes FOLDER: prints its size
megabytes() { du -sm "$1" 2>/dev/null | cut -f 1; }

# progress SECONDS TEXT: rewrites one line on a terminal; elsewhere prints a new line every ten seconds
progress() {
  if [[ -t 1 ]]; then
    printf '\r\033[K  %3d s  %s' "$1" "$2"
  elif (($1 > 0 && $1 % 10 == 0 && $1 != last_progress)); then
    printf '  %3d s  %s\n' "$1" "$2"
  fi
  last_progress=$1
}

# The started steps: their processes (empty after their end), their start times, and folders whose size shows their
# progress
step_children=() step_starts=() step_titles=() step_folders=()
step= # number of the newest step

# start_step TITLE COMMAND...: runs it in parallel to the next commands, until `finish_step "$step"`. With
# growing=FOLDER before it, the progress is this folder's size.
start_step() {
  local title=$1
  shift
  step=${#step_titles[@]}
  say "$title ..."
  printf '\n== %s: %s ==\n' "$title" "$*" >"$log_file.$step"
  set -m # in a separate process group, so that an interrupt ends all of it
  note_code "$log_file.$step.code" "$@" >>"$log_file.$step" 2>&1 </dev/null &
  set +m
  step_titles+=("$title") step_starts+=("$SECONDS") step_children+=("$!") step_folders+=("${growing:-}")
  trap stop_steps EXIT
  trap '[[ ! -t 1 ]] || echo; fail "Interrupted. The next call goes on from here."' INT TERM
}

# note_code FILE COMMAND...: writes the command's code into the file, and when it ended. The shell forgets the codes of
# processes that ended long before it waits for them, and only then would see the time.
note_code() {
  local code=0
  "${@:2}" || code=$?
  echo "$code $SECONDS" >"$1"
  return "$code"
}

# finish_step NUMBER: shows progress until the step ends, adds its output to the log, returns its code
finish_step() {
  local child=${step_children[$1]} last_progress=0 code=0 ended elapsed size="" sized=-10
  while kill -0 "$child" 2>/dev/null; do
    sleep 0.2
    elapsed=$((SECONDS - step_starts[$1]))
    if [[ -n ${step_folders[$1]} ]] && ((elapsed - sized >= 5)); then
      size="$(megabytes "${step_folders[$1]}") MB, " sized=$elapsed
    fi
    progress "$elapsed" "$size$(last_line "$log_file.$1")"
  done
  wait "$child" 2>/dev/null || code=$?
  ended=$SECONDS
  [[ ! -s $log_file.$1.code ]] || read -r code ended <"$log_file.$1.code"
  rm -f "$log_file.$1.code"
  step_children[$1]=
  collect_log "$1"
  [[ ${step_children[*]} == *[0-9]* ]] || trap - EXIT INT TERM
  [[ ! -t 1 ]] || printf '\r\033[K'
  ((code != 0)) || say "${step_titles[$1]}: done in $((ended - step_starts[$1])) s"
  return "$code"
}

# collect_log NUMBER
collect_log() { cat "$log_file.$1" >>"$log_file" && rm -f "$log_file.$1"; }

# stop_steps: ends all running steps
stop_steps() {
  local number
  for number in "${!step_children[@]}"; do
    [[ -n ${step_children[$number]} ]] || continue
    kill -- "-${step_children[$number]}" 2>/dev/null
    collect_log "$number"
  done
}

# run_step TITLE COMMAND...: runs it, shows progress, adds its output to the log, and returns its code
run_step() {
  start_step "$@"
  finish_step "$step"
}
