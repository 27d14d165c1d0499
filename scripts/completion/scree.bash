# Completion of scree for bash, written by scripts/document_commands.py; do not edit it.
_scree() {
   local program="${COMP_WORDS[0]}" word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" words
   local IFS=$' \t\n'
   COMPREPLY=()
   case "${before}" in
      --list) words="materials fields shapes units examples messages" ;;
      --new) words="$("${program}" --list examples 2> /dev/null | cut -d ' ' -f 1)" ;;
      --explain | -s | --set | --unset)
         words="$("${program}" --template 2> /dev/null \
            | awk '/^&/ {g = substr($1, 2); if ("'"${before}"'" == "--explain") print g}
                   g != "" && /^[! ] *[a-z_0-9]+ *=/ {sub(/^! */, ""); print g "." $1} /^\/$/ {g = ""}')"
         if [[ "${before}" == --explain ]]; then
            words+=" $("${program}" --list messages 2> /dev/null | cut -d ' ' -f 1)"
         fi ;;
      --case | -c) words="" ;;
      --outdir | -o)
         mapfile -t COMPREPLY < <(compgen -d -- "${word}")
         compopt -o filenames 2> /dev/null
         return ;;
      --job) words="slurm pbs" ;;
      --nodes) words="" ;;
      --ranks) words="" ;;
      --threads) words="" ;;
      --time) words="" ;;
      *)
         if [[ "${word}" == -* ]]; then
            words="--check -n --no-estimate --preview -p --echo --set -s --unset --case -c --outdir -o --restart -r --overwrite --quiet -q --force --template --explain --point --grains --list --new --job --nodes --ranks --threads --time --digest --self-test --help -h --version -V"
         else
            mapfile -t COMPREPLY < <(compgen -d -- "${word}"; compgen -f -X '!*.nml' -- "${word}"
               case "${before}" in -r | --restart | --digest) compgen -f -X '!*.h5' -- "${word}" ;; esac)
            compopt -o filenames 2> /dev/null
            return
         fi ;;
   esac
   mapfile -t COMPREPLY < <(compgen -W "${words}" -- "${word}")
}
complete -F _scree scree
