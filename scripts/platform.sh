# shellcheck shell=bash
# Finds out on what this runs. What cannot work ends with one sentence before anything is changed. setup.sh sources
# this file.

: "${os_release:=/etc/os-release}" "${system_python:=/usr/bin/python3}"
readonly pythons="3.11 3.12 3.13" # the packages of requirements.txt have wheels for these
declare -rA python_of=([debian-12]=3.11 [debian-13]=3.13)
# ROS's packages on Debian. Where ROS comes from elsewhere, they are not installed beside it.
readonly packages_of_ros='^(catkin|rosbash|rviz|ros-.*|python3-(ros.*|rviz|tf2-ros|actionlib.*|dynamic-reconfigure|.*-msgs|std-srvs)|lib(rostest|.*-msgs|std-srvs|dynamic-reconfigure.*)-dev)$'

# detect_platform: sets `platform`, for example debian-12, and `package_list`, the file with its packages
detect_platform() {
  local id version like
  IFS='|' read -r id version like < <(. "$os_release" && echo "${ID:-unknown}|${VERSION_ID:-of unknown version}|${ID_LIKE:-}")
  platform=$id-$version package_list=scripts/packages/$id-$version.txt ros_is_there=
  check_processor
  system_version=$(minor_version "$system_python")
  if [[ -f $package_list ]]; then
    check_interpreter "${python_of[$platform]}" "the ROS of $platform needs Python ${python_of[$platform]}"
  else
    try_untested "$id $version" " $id $like "
  fi
  check_venv
}

# minor_version PYTHON: prints for example 3.11; nothing where it does not run
minor_version() { { "$1" --version 2>/dev/null || true; } | sed -n 's/^Python \([0-9]*\.[0-9]*\).*/\1/p'; }

# check_processor: three of the pinned packages are published for one kind of processor only
check_processor() {
  local processor
  processor=$(uname -m)
  [[ $processor == x86_64 ]] || fail \
    "This machine's processor is $processor, and pybullet, embreex and pyoctomap have packages for x86_64 only: nothing was changed (see doc/platforms.md)."
}

# check_interpreter VERSION REASON: a bare system has no interpreter yet; apt-get brings the right one
check_interpreter() {
  [[ -z $system_version || " $1 " == *" $system_version "* ]] || fail \
    "$system_python is Python $system_version, and $2: make it the distribution's own again, or use a container (see doc/platforms.md)."
}

# try_untested NAME KINDS: goes on with a warning on a Debian or Ubuntu that has rospy
try_untested() {
  [[ $2 == *" debian "* || $2 == *" ubuntu "* ]] || fail \
    "This is $1; the set-up needs Debian's packages, and only Debian 12 and 13 are tested (see doc/platforms.md)." \
    "A container does as well, for example: docker run -it -v \"\$PWD\":/ws -w /ws debian:13 ./bringup.sh"
  if "$system_python" -c 'import rospy, sys; sys.exit(rospy.__file__.startswith("/usr/lib/python3/"))' 2>/dev/null; then
    ros_is_there=yes
  else
    apt-cache show python3-rospy >/dev/null 2>&1 || fail \
      "This is $1, which is not tested, and $system_python finds no rospy: source ROS's setup.bash first, or call apt-get update if python3-rospy is a package here (see doc/platforms.md)."
  fi
  [[ " $pythons " == *" $system_version "* ]] || fail \
    "This is $1 with Python $system_version, and requirements.txt has packages for Python 3.11 to 3.13 only: use a container of debian:13 (see doc/platforms.md)."
  package_list=scripts/packages/debian-12.txt
  [[ $system_version != "${python_of[debian-13]}" ]] || package_list=scripts/packages/debian-13.txt
  say "warning: this is $1, which is not tested; trying with the packages of $(basename "$package_list" .txt) that are there (see doc/platforms.md)"
}

# listed_packages [END]: prints the packages of the list, one per line; those before the line that begins with END. On
# an untested system those that it does not have are left out, and those of ROS if that is there.
listed_packages() {
  local listed
  listed=$(sed -n "${1:+\\|^$1|q;}/^[^#]/p" "$package_list" | sort)
  [[ -z $ros_is_there ]] || listed=$(grep -vE "$packages_of_ros" <<<"$listed")
  [[ -n ${python_of[$platform]:-} ]] || listed=$(comm -12 <(echo "$listed") <(apt-cache pkgnames | sort))
  echo "$listed"
}

# check_venv: sets `venv_fault`, why .venv cannot be kept. That of another Python has none of its packages for this one.
# Without numpy of its own, nodes would take the distribution's, which has another version.
check_venv() {
  local home version numpy
  venv_fault=
  [[ -f .venv/pyvenv.cfg ]] || return 0
  home=$(sed -n 's/^home = //p' .venv/pyvenv.cfg) version=$(sed -n 's/^version = \([0-9]*\.[0-9]*\).*/\1/p' .venv/pyvenv.cfg)
  numpy=.venv/lib/python$version/site-packages/numpy
  if [[ -n $system_version && $home/$version != $(dirname "$system_python")/$system_version ]]; then
    venv_fault="was made by Python $version of $home, and ROS's is Python $system_version of $(dirname "$system_python")"
  elif [[ -f .venv/.bringup && (! -d $numpy || -L $numpy) ]]; then
    venv_fault="has no numpy of its own, so nodes would take the distribution's"
  fi
}

# name_other_python: tells whoever has another python3 first on the PATH that the set-up does not take it
name_other_python() {
  local other
  other=$(PATH=${caller_path:-$PATH} type -P python3 || true)
  [[ -z $other || $(minor_version "$other") == "$(minor_version "$system_python")" ]] || say \
    "the first python3 of the PATH is $other, Python $(minor_version "$other"); .venv is made with $system_python, Python $(minor_version "$system_python"), which knows ROS"
}

# remove_bad_venv: deletes a .venv that cannot be kept, and the build, which knows its Python
remove_bad_venv() {
  [[ -n $venv_fault ]] || return 0
  say ".venv $venv_fault; making it anew, and the build"
  rm -rf build devel .venv
}
