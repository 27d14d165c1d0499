# Completion of scree-bench for bash, written by scripts/document_commands.py; do not edit it.
_scree_bench() {
   local word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" words=""
   local IFS=$' \t\n'
   COMPREPLY=()
   if [[ "${word}" == -* ]]; then
      words="-h --help --list --size --only --layouts --repeat --scree --turns --mpiexec --out --markdown --work --show --compare --limit -V --version"
   else
      case "${before}" in
         --size) words="small full" ;;
         --only) words="block_ddmp block_mpm irregular_ddmp irregular_mpm block_gimp block_quadratic block_cubic block_cpdi metal_ddmp metal_ddmp_flip metal_mpm column plane_strain_ddmp plane_strain_mpm axisymmetric_ddmp axisymmetric_mpm line_ddmp debris sparse block_ddmp_2x1 block_ddmp_1x2 block_mpm_2x1 block_mpm_1x2 debris_2x1 debris_1x2" ;;
         --work) mapfile -t COMPREPLY < <(compgen -d -- "${word}") ;;
         --scree | --turns) mapfile -t COMPREPLY < <(compgen -f -- "${word}") ;;
         --markdown) mapfile -t COMPREPLY < <(compgen -d -- "${word}"; compgen -f -X '!*.md' -- "${word}") ;;
         --repeat | --layouts | --mpiexec | --limit) ;;
         *) mapfile -t COMPREPLY < <(compgen -d -- "${word}"; compgen -f -X '!*.json' -- "${word}") ;;
      esac
   fi
   if [[ -z "${words}" ]]; then
      compopt -o filenames 2> /dev/null
      return
   fi
   mapfile -t COMPREPLY < <(compgen -W "${words}" -- "${word}")
}
complete -F _scree_bench scree-bench
