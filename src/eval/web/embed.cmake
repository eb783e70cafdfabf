# Writes OUTPUT, a header with texts: LIBRARIES (the licence, then the scripts it covers; may be
# empty) and the script OWN.
set(libraries "")
if(LIBRARIES)
  list(POP_FRONT LIBRARIES licence_file)
  file(READ ${licence_file} licence)
  string(FIND "${licence}" "Permission is hereby granted" begin)
  if(begin LESS 0)
    message(FATAL_ERROR "${licence_file}: does not contain the licence of three.js")
  endif()
  string(SUBSTRING "${licence}" ${begin} -1 licence)
  set(libraries "/*! three.js (https://threejs.org), Copyright (c) 2010-2017 three.js authors\n\n ${licence}*/\n")
  foreach(file ${LIBRARIES})
    file(READ ${file} script)
    string(APPEND libraries "${script}\n")
  endforeach()
endif()
file(READ ${OWN} own)
file(WRITE ${OUTPUT} "// Generated: scripts of the report.\n#pragma once\nnamespace tetrec {\n"
  "// Licence and text of three.js; empty if the build had none.\n"
  "inline constexpr const char* kThreeScript = R\"TETREC_JS(${libraries})TETREC_JS\";\n"
  "inline constexpr const char* kSceneScript = R\"TETREC_JS(${own})TETREC_JS\";\n}  // namespace tetrec\n")
