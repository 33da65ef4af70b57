# shellcheck shell=bash
# Builds the handbook: makes an environment of its own for mkdocs, and calls scripts/handbook. bringup.sh sources this
# file. ROS, .venv and the build are not needed, and none of them changes.

: "${root:?is set by bringup.sh}" "${log_file:?is set by bringup.sh}"
readonly docs_packages=scripts/packages/docs.txt docs_needs_mb=250

# docs_inputs: prints a digest of the environment's inputs
docs_inputs() { cat "$docs_packages" <("$system_python" --version 2>/dev/null) <(echo "$root") | sha256sum; }

# make_docs_environment: installs the packages; only what is complete gets a stamp
make_docs_environment() {
  local pip=(env -u PYTHONPATH .docs/env/bin/python -m pip install --no-input --disable-pip-version-check --prefer-binary)
  "$system_python" -m venv --clear .docs/env && "${pip[@]}" --no-compile -r "$docs_packages" && docs_inputs >.docs/.bringup
}

# set_up_docs: makes what builds the handbook ready
set_up_docs() {
  # A bare machine has no module venv yet; the set-up installs it.
  detect_platform
  "$system_python" -c 'import ensurepip' 2>/dev/null || set_up
  mkdir -p logs .docs
  if ! is_current .docs/.bringup "$(docs_inputs)"; then
    require_disk "$root" "$docs_needs_mb"
    growing=.docs/env run_step "installing what builds the handbook into .docs" make_docs_environment ||
      explain_failure "The packages of $docs_packages could not be installed; the pages can be read without them, from README.md on."
  fi
}

# run_docs [ARGUMENT ...]: builds the handbook
run_docs() {
  set_up_docs
  exec env PYTHONPATH=scripts NO_MKDOCS_2_WARNING=1 .docs/env/bin/python -m handbook "$@"
}
