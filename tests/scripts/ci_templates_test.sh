#!/usr/bin/env bash
# Runs the steps of docs/ci as a runner would, with a capture of the fake worker: what they write, and that a gate that
# failed fails the job.
#   ci_templates_test.sh SUBPIXEL FAKE_WORKER
set -euo pipefail
subpixel=$(realpath "$1") fake=$(realpath "$2")
cd "$(dirname "$0")/../.."
root=$PWD
python3 -c 'import yaml' 2>/dev/null || { echo "skipped: python3-yaml is not installed"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/repository" && cd "$folder/repository"
tweak=$folder/data/cache/tweak.json
printf 'FAKE {"frames":1,"tweak":"%s"}\n' "$tweak" >one.spcap
cat >nightly.json <<'J'
{"name": "ci", "techniques": "noaa,msaa", "size": [32, 18], "frames": [0, 0], "reference_samples": 0,
 "captures": [{"path": "one.spcap"}]}
J
# The program with the fake worker.
printf '#!/bin/sh\nverb=$1; shift\nexec "%s" "$verb" --worker-program "%s" "$@"\n' "$subpixel" "$fake" >"$folder/program"
chmod +x "$folder/program"

# What a runner does with the `run` of a composite action's steps, or with the `script` of a job.
cat >"$folder/runner.py" <<'P'
import os, re, subprocess, sys, yaml
kind, path = sys.argv[1:3]
given = dict(pair.split('=', 1) for pair in sys.argv[3:])
document = yaml.safe_load(open(path))
if kind == 'action':
    inputs = {name: given.get(name, spec.get('default', '')) for name, spec in document['inputs'].items()}
    for name, spec in document['inputs'].items():
        assert name in given or not spec.get('required'), name
    for step in document['runs']['steps']:
        assert step['shell'] == 'bash'
        env = {k: re.sub(r'\$\{\{ inputs\.(\w+) \}\}', lambda m: inputs[m[1]], v) for k, v in step['env'].items()}
        code = subprocess.call(['bash', '--noprofile', '--norc', '-eo', 'pipefail', '-c', step['run']], env={**os.environ, **env})
        if code: sys.exit(code)
else:
    job = document['.subpixel-night']
    env = {**os.environ, **job['variables'], **given}
    for line in job['script']:
        code = subprocess.call(['bash', '-eo', 'pipefail', '-c', line], env=env)
        if code: sys.exit(code)
P
fail() { echo "ci_templates_test: $*" >&2; exit 1; }
action() {
  GITHUB_SHA=abc123 GITHUB_OUTPUT=$folder/output GITHUB_STEP_SUMMARY=$folder/summary.md \
    python3 "$folder/runner.py" action "$root/docs/ci/action/action.yml" config=nightly.json data="$folder/data" \
    subpixel="$folder/program" address=http://localhost:1 2>>"$folder/log"
}
gitlab() {
  CI_COMMIT_SHA=abc123 python3 "$folder/runner.py" gitlab "$root/docs/ci/gitlab.yml" SUBPIXEL_PROGRAM="$folder/program" \
    NIGHT_DATA="$folder/data" >/dev/null 2>>"$folder/log"
}
action || fail "the first night failed: $(cat "$folder/log")"
grep -q '^status=passed$' "$folder/output" || fail "the output does not say that it passed"
grep -q 'commit abc123' "$folder/summary.md" || fail "the summary lacks the commit"
"$subpixel" baseline set ci --data "$folder/data" >/dev/null
gitlab || fail "the second night failed: $(cat "$folder/log")"
for file in night.xml night.md comment.md night.sarif; do [ -s "$file" ] || fail "$file is not written"; done
echo '{"technique": "noaa", "executions": 5}' >"$tweak"
code=0; gitlab || code=$?
[ "$code" = 1 ] || fail "exit code $code of a job whose gate failed"
python3 - <<'P' || fail "the SARIF document is wrong"
import json
run, = json.load(open('night.sarif'))['runs']
result, = run['results']
assert result['ruleId'] == 'shading' and result['locations'][0]['physicalLocation']['artifactLocation']['uri'] == 'nightly.json'
assert 'one, noaa' in result['message']['text'], result
P
: >"$folder/output"
code=0; action || code=$?
[ "$code" = 1 ] || fail "exit code $code of an action whose gate failed"
grep -q '^status=failed$' "$folder/output" || fail "the output does not say that it failed"
comment=$(sed -n 's/^comment=//p' "$folder/output")
grep -q 'http://localhost:1/#/nights/' "$comment" || fail "the comment has no link"
# A cell under another name than the summary's is told what it is called.
code=0; told=$("$subpixel" nightly trend --data "$folder/data" --name ci --capture one --technique msaa 2>&1) || code=$?
[ "$code" = 3 ] || fail "exit code $code of a trend of no cell"
[[ $told == *"one by msaa; it was measured by "*"msaa:samples=8"* ]] || fail "the refusal does not name the cells: $told"
echo "ci_templates_test: passed"
