# Sourced by the other scripts: where things are and which tools they use, whatever the caller's environment.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$root/.work
# shellcheck disable=SC2034 # used by those who source this
build=$work/build

# ROS and its Python modules belong to the system's python3, which need not be the caller's first.
export PATH=/usr/bin:$PATH
export PYTHONUNBUFFERED=1
unset PYTHONHOME

# Logs stay in the checkout; the nodes of one machine find each other without a resolvable host name.
export HOME=${HOME:-$work} ROS_HOME=$work/ros ROS_IP=127.0.0.1
unset ROS_HOSTNAME ROS_MASTER_URI ROS_NAMESPACE

# roscpp reserves memory for every file it may open, which containers often put at a thousand million.
if [[ $(ulimit -Sn) == unlimited || $(ulimit -Sn) -gt 65536 ]]; then ulimit -Sn 65536; fi

# The setup files of ROS read unset variables.
source_setup() {
  set +u
  # shellcheck disable=SC1090
  source "$1"
  set -u
}
if [[ -f /opt/ros/noetic/setup.bash ]]; then source_setup /opt/ros/noetic/setup.bash; fi

say() { printf '%s\n' "$*" >&2; }

# run_quietly NAME COMMAND...: what it says goes to .work/NAME.log, and is shown when it fails.
run_quietly() {
  local log=$work/$1.log
  shift
  "$@" >"$log" 2>&1 || { cat "$log" >&2; return 1; }
}
