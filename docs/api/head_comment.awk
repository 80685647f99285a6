# SPDX-License-Identifier: Apache-2.0
# The comment that begins a header, as Doxygen's description of the file.
BEGIN { head = 1; print "/// \\file" }
head && /^\/\/ SPDX/ { print "///"; next }
head && /^\/\// { sub(/^\/\/+/, "///"); print; next }
{ head = 0; print }
