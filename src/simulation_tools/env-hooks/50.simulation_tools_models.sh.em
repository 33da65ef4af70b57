# Adds the models of simulation_tools to GAZEBO_MODEL_PATH, once, and leaves what the user had before it.
@[if DEVELSPACE]@
_simulation_tools_models="@(CMAKE_CURRENT_SOURCE_DIR)/models"
@[else]@
_simulation_tools_models="$CATKIN_ENV_HOOK_WORKSPACE/@(CATKIN_PACKAGE_SHARE_DESTINATION)/models"
@[end if]@
case ":$GAZEBO_MODEL_PATH:" in
  *":$_simulation_tools_models:"*) ;;
  *) export GAZEBO_MODEL_PATH="${GAZEBO_MODEL_PATH:+$GAZEBO_MODEL_PATH:}$_simulation_tools_models" ;;
esac
unset _simulation_tools_models
