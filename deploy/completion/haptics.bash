# Completion of every program of the runtime, from its own --help: subcommands, options, and files for everything else.
_haptics() {
  local current=${COMP_WORDS[COMP_CWORD]} command=("$1") subcommands
  subcommands=$("$1" --help 2>/dev/null | awk '/^Subcommands:/ { on = 1; next } on && /^  [a-z]/ { print $1 }')
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    if grep -qxF -- "$word" <<<"$subcommands"; then
      command+=("$word")
      break
    fi
  done
  COMPREPLY=()
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("${command[@]}" --help 2>/dev/null | grep -oE -- '--[a-z][a-z0-9-]*' | sort -u)" -- "$current")
  elif [ ${#command[@]} -eq 1 ] && [ -n "$subcommands" ]; then
    mapfile -t COMPREPLY < <(compgen -W "$subcommands" -- "$current")
  fi
} && complete -o bashdefault -o default -F _haptics haptic_server graphics_client hapticctl haptic_relay haptic_igtl haptic_ros2 haptic_eval mesh_report
