# Writes OUTPUT, a header with FOLDER/view.html, its style sheet and its script in place.
file(READ ${FOLDER}/view.html page)
foreach(part view.css view.js)
  file(READ ${FOLDER}/${part} text)
  string(REPLACE "{{${part}}}" "${text}" page "${page}")
endforeach()
file(WRITE ${OUTPUT} "// Generated: the viewer's page.\n#pragma once\nnamespace tetrec {\n"
  "inline constexpr const char* kViewPage = R\"TETREC_VIEW(${page})TETREC_VIEW\";\n}  // namespace tetrec\n")
