#!/bin/sh
# Isolated from the packages of the system, which RenderDoc's module is one of.
exec /usr/bin/python3 -S "$@"
