#!/usr/bin/env python3
"""The simulated controller runs the compensated program; the servo log, pushed through the forward model, must stay on
the path of the original.  follow_path.py ABBE SIMULATOR FOLDER   (exit 77: no simulator)"""
import csv
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

ALLOWED_MM = 0.0025  # tolerance 1 um, digits, and what the controller's spline smooths between servo cycles


def points_of(program):
    """Ends of the feed moves, program coordinates: with tool offset = gauge length they are tips in the workpiece."""
    at, found = {}, []
    feeding = False
    for line in open(program):
        words = dict((w[0], float(w[1:])) for w in re.findall(r'[XYZ][-+.0-9]+', line.split('(')[0]))
        at.update(words)
        feeding = (feeding or 'G1' in line.split()) and 'G0' not in line.split()
        if words:
            found.append((feeding, (at['X'], at['Y'], at['Z'])))
    start = next(i for i, (feed, _) in enumerate(found) if feed)
    return [found[start - 1][1]] + [p for feed, p in found if feed]


def distance(p, path):
    best = math.inf
    for a, b in zip(path, path[1:]):
        d = [y - x for x, y in zip(a, b)]
        square = sum(x * x for x in d)
        t = 0 if square == 0 else max(0, min(1, sum((p[k] - a[k]) * d[k] for k in range(3)) / square))
        best = min(best, math.dist(p, [a[k] + t * d[k] for k in range(3)]))
    return best


def main():
    abbe, simulator, folder = sys.argv[1:4]
    if not os.path.exists('/usr/bin/milltask') or not os.path.exists(os.path.join(simulator, 'runsim.sh')):
        print('no simulated controller here: skipped')
        return 77
    if subprocess.run(['unshare', '--ipc', '--pid', '--fork', '--mount-proc', 'true'], capture_output=True).returncode != 0:
        print('no namespaces of its own for the controller here: skipped')
        return 77
    with tempfile.TemporaryDirectory() as work:
        os.chmod(work, 0o777)
        for name in ('runsim.sh', 'drive.py', 'sim5.ini', 'sim5.hal', 'fastclock.c'):
            shutil.copy(os.path.join(simulator, name), work)
            os.chmod(os.path.join(work, name), 0o755)
        open(os.path.join(work, 'tool.tbl'), 'w').write('T1 P1 Z100.5 D10 ;mill\n')
        program, machine = os.path.join(folder, 'path.ngc'), os.path.join(folder, 'machine.toml')
        output = os.path.join(work, 'out.ngc')
        subprocess.run([abbe, 'compensate', machine, program, '-o', output, '--offset', 'G54=X0,Y0,Z0', '--tools',
                        os.path.join(work, 'tool.tbl'), '--datum', 'ideal', '--header', 'none', '--tool-change', 'keeps',
                        '--start', 'X0,Y0,Z0'], check=True)
        worst = {}
        for name, path in (('original', program), ('compensated', output)):
            log = os.path.join(work, name + '.log')
            subprocess.run([os.path.join(work, 'runsim.sh'), os.path.join(work, 'sim5.ini'), path, log], check=True, timeout=120)
            rows = [list(map(float, line.split()[1:])) for line in open(log) if line[:1].isdigit() and 'overrun' not in line]
            lines = open(path).read().split('\n')
            feed = [i + 1 for i, line in enumerate(lines) if re.search(r'[XYZAC]', line.split('(')[0])]
            first, last = feed[1], feed[-2]
            used = [r for r in rows if first <= r[10] <= last]
            if len(used) < 1000:
                print('the servo log is too short: %d cycles' % len(used))
                return 1
            with open(os.path.join(work, 'q.csv'), 'w', newline='') as file:
                writer = csv.writer(file)
                writer.writerow(['X', 'Y', 'Z', 'A', 'C'])
                writer.writerows(['%.6f' % v for v in r[:5]] for r in used[::5])
            answer = subprocess.run([abbe, 'predict', machine, '--points', os.path.join(work, 'q.csv'), '--json'], check=True,
                                    capture_output=True)
            path_points = points_of(program)
            tips = [p['actual']['position_mm'] for p in json.loads(answer.stdout)['points']]
            worst[name] = max(distance(p, path_points) for p in tips)
            print('%s: %d places, at most %.2f um from the path' % (name, len(tips), worst[name] * 1e3))
        ok = worst['compensated'] <= ALLOWED_MM and worst['original'] > 5 * ALLOWED_MM
        print('PASS' if ok else 'FAIL')
        return 0 if ok else 1


sys.exit(main())
