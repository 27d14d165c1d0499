#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Usage: compile_relative.sh SOURCES COMMAND ...
#
# Compiles a file below the folder SOURCES, or below the current folder, under its path in that
# folder. gfortran writes the name of a file, as it is given, into messages of run time errors, and
# has no option that maps it, so without this script programs would contain the path of the folder
# of the build and differ from one folder to another.
root="$1"
shift
build="${PWD}"
place=
previous=
for word; do
   if [ "${previous}" = -c ]; then
      case "${word}" in
         "${build}"/*) place="${build}" ;;
         "${root}"/*) place="${root}" ;;
      esac
   fi
   previous="${word}"
done
if [ -z "${place}" ]; then
   exec "$@"
fi
# The other paths are relative too, where they can be: options are part of debug information, and
# gfortran 12 has been seen to order components in a finalizer by the length of the paths of
# modules.
case "${place}" in
   "${build}") here= ;;
   *)
      case "${build}" in
         "${place}"/*) here="${build#"${place}"/}/" ;;
         *) here="${build}/" ;;
      esac
      ;;
esac
previous=
for word; do
   shift
   case "${previous}" in
      -c) word="${word#"${place}"/}" ;;
      -o)
         case "${word}" in
            /*) ;;
            *) word="${here}${word}" ;;
         esac
         ;;
   esac
   previous="${word}"
   case "${word}" in
      -I"${place}"/*) word="-I${word#-I"${place}"/}" ;;
      -J"${place}"/*) word="-J${word#-J"${place}"/}" ;;
      -J/* | -I/* | -J | -I | -module-dir/* | -module-dir) ;;
      -J*) word="-J${here}${word#-J}" ;;
      -module-dir*) word="-module-dir${here}${word#-module-dir}" ;; # flang
      -I*) word="-I${here}${word#-I}" ;;
   esac
   set -- "$@" "${word}"
done
cd "${place}" && exec "$@"
