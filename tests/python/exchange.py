"""For tests/unit/python_capture_test.cpp: `write FILE` writes the fixture, `compare A B` fails where they differ."""
import sys

from capture_fixture import small_capture, spcap

if sys.argv[1] == "write":
    spcap.write(small_capture(), sys.argv[2])
elif spcap.read(sys.argv[2]) != spcap.read(sys.argv[3]):
    sys.exit("the captures differ")
