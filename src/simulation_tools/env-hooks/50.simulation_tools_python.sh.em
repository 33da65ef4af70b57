# ROS's own scripts (rosrun dynamic_reconfigure dynparam, ...) run on the first python3 of the PATH. Where that knows
# nothing of ROS (pyenv, conda, another venv), the interpreter that this workspace was built with goes before it.
if ! python3 -c 'import rospkg, roslib' >/dev/null 2>&1; then
  export PATH="@(PYTHON_EXECUTABLE.rpartition('/')[0]):$PATH"
fi
