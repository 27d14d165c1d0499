# SPDX-License-Identifier: BSD-3-Clause
# Fortran text from a list of names.
#
#   scree_catalogue(laws PREFIX law_ ASSIGN law)
#
# sets for a template, with laws = elastic von_mises:
#   laws_uses    use law_elastic, only: law_elastic_t                  (one line a name)
#   laws_cases   case ("elastic"); allocate (law_elastic_t :: law)     (two lines a name)
#   laws_names   "elastic     ", "von_mises   "   for an array constructor of equal lengths
#   laws_count   2
#   laws_length  9, the length of the longest name

function(scree_catalogue list)
   cmake_parse_arguments(catalogue "" "PREFIX;ASSIGN" "" ${ARGN})
   set(names "${${list}}")
   set(uses)
   set(cases)
   set(texts)
   set(longest 1)
   foreach(name IN LISTS names)
      string(LENGTH "${name}" length)
      if(length GREATER longest)
         set(longest ${length})
      endif()
   endforeach()
   set(sorted ${names})
   list(SORT sorted)
   foreach(name IN LISTS sorted)
      set(module "${catalogue_PREFIX}${name}")
      list(APPEND uses "   use ${module}, only: ${module}_t")
   endforeach()
   foreach(name IN LISTS names)
      set(module "${catalogue_PREFIX}${name}")
      list(APPEND cases
         "      case (\"${name}\")\n         allocate (${module}_t :: ${catalogue_ASSIGN})")
      set(padded "${name}")
      string(LENGTH "${padded}" length)
      while(length LESS longest)
         string(APPEND padded " ")
         string(LENGTH "${padded}" length)
      endwhile()
      list(APPEND texts "      \"${padded}\"")
   endforeach()
   list(LENGTH names count)
   list(JOIN uses "\n" uses)
   list(JOIN cases "\n" cases)
   list(JOIN texts ", &\n" texts)
   set(${list}_uses "${uses}" PARENT_SCOPE)
   set(${list}_cases "${cases}" PARENT_SCOPE)
   set(${list}_names "${texts}" PARENT_SCOPE)
   set(${list}_count "${count}" PARENT_SCOPE)
   set(${list}_length "${longest}" PARENT_SCOPE)
endfunction()
