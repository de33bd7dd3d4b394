"""The same run on two hosts as on one. `./hotbed validate hosts [--quick]`: four ranks, --quick two.

The hosts are network namespaces of this machine, each with a name and an sshd of its own, that see each other through a pair
of virtual network cards only; ranks on different hosts talk TCP. Needs root and the Debian packages openssh-server,
openssh-client, iproute2; nothing outside the two namespaces and a temporary folder is changed.

Scene: that of `validate restart`, compared after END.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
import run as hotbed
from validate_restart import STEP, difference, particles, scene

PREFIX = f"hotbed{os.getpid()}"
HOSTS = {f"{PREFIX}a": "10.77.0.1", f"{PREFIX}b": "10.77.0.2"}
END = 0.004  # [s]
SKIP = 77


def sh(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def on(host, *command):
    """A command as it runs on a host."""
    return ["ip", "netns", "exec", host, "unshare", "--uts", "sh", "-c", 'hostname "$0" && exec "$@"', host, *command]


def obstacle():
    """Why this machine cannot have the two hosts, or None."""
    missing = [program for program in ("ip", "ssh", "/usr/sbin/sshd", "ssh-keygen") if not shutil.which(program)]
    if missing:
        return f"{', '.join(missing)} missing: apt-get install openssh-server openssh-client iproute2"
    if os.geteuid() != 0:
        return "only root may make network namespaces"
    tried = subprocess.run(["ip", "netns", "add", PREFIX], capture_output=True, text=True)
    if tried.returncode != 0:
        return f"no network namespaces here: {tried.stderr.strip()}"
    sh("ip", "netns", "del", PREFIX)
    return None


@contextmanager
def network():
    """The two hosts, wired to each other."""
    first, second = HOSTS
    try:
        for host in HOSTS:
            sh("ip", "netns", "add", host)
        sh("ip", "link", "add", "eth0", "netns", first, "type", "veth", "peer", "name", "eth0", "netns", second)
        for host, address in HOSTS.items():
            sh("ip", "-n", host, "address", "add", f"{address}/24", "dev", "eth0")
            for card in ("lo", "eth0"):
                sh("ip", "-n", host, "link", "set", card, "up")
        yield
    finally:
        for host in HOSTS:
            subprocess.run(["ip", "netns", "del", host], capture_output=True)


@contextmanager
def daemons(folder):
    """An sshd on each host, which know nothing but a key made for them. @return the ssh command that they let in"""
    Path("/run/sshd").mkdir(exist_ok=True)
    for key in ("host", "user"):
        sh("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", f"{folder}/{key}")
    running = []
    try:
        for host, address in HOSTS.items():
            config = folder / f"{host}.config"
            config.write_text(f"ListenAddress {address}\nHostKey {folder}/host\nAuthorizedKeysFile {folder}/user.pub\n"
                              f"StrictModes no\nPermitRootLogin prohibit-password\nUsePAM yes\nPidFile none\n")
            with open(folder / f"{host}.log", "w") as log:
                running.append(subprocess.Popen(on(host, "/usr/sbin/sshd", "-D", "-e", "-f", str(config)), stderr=log))
        ssh = f"ssh -F none -i {folder}/user -o BatchMode=yes -o StrictHostKeyChecking=no -o UserKnownHostsFile=/dev/null -o LogLevel=ERROR"
        first, second = HOSTS
        for attempt in range(50):
            answer = subprocess.run(on(first, *ssh.split(), HOSTS[second], "hostname"), capture_output=True, text=True)
            if answer.stdout.strip() == second:
                break
            time.sleep(0.2)
        else:
            raise RuntimeError(f"no ssh from host to host: {answer.stderr}{(folder / f'{second}.log').read_text()}")
        yield ssh
    finally:
        for process in running:
            process.terminate()
            process.wait()


def run_on_hosts(run, ranks, folder, ssh):
    """As `hotbed run` starts it, from the first host, told of the hosts as docs/cluster.md says.

    @return bytes that the first host sent
    """
    first, *_ = HOSTS
    hostfile = folder / "hosts"
    hostfile.write_text("".join(f"{address} slots={ranks // len(HOSTS)}\n" for address in HOSTS.values()))
    told = {"OMPI_MCA_orte_default_hostfile": str(hostfile), "OMPI_MCA_plm_rsh_agent": ssh,
            "PYTHONPATH": str(ROOT / "cfd_solver")}
    script = f"import run; run.run_case({str(run.resolve())!r}, {ranks})"
    subprocess.run(on(first, "/usr/bin/python3", "-c", script), env={**os.environ, **told}, check=True)
    return int(sh("ip", "netns", "exec", first, "cat", "/sys/class/net/eth0/statistics/tx_bytes"))


def ranks_by_host(run):
    """host -> ranks, from the head of the log."""
    listed = re.search(r"(?m)^Hosts  :\n\(\n((?:    .*\n)*)\)", (run / "log.hotbedFoam").read_text())
    return {host: int(count) for host, count in re.findall(r"\((\S+) (\d+)\)", listed[1])} if listed else {}


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate hosts", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="two ranks")
    ranks = 2 if parser.parse_args().quick else 4
    if reason := obstacle():
        print(f"hotbed: validate hosts is skipped: {reason}", file=sys.stderr)
        sys.exit(SKIP)
    figures = results.Figures("hosts")
    target = Path("results") / "hosts" / f"ranks-{ranks}"
    step = round(END / STEP)
    one, two = (scene(target, name, ranks, "1e-4", END, END) for name in ("one", "two"))
    hotbed.run_case(one, ranks)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="hotbed-hosts-")))
        stack.enter_context(network())
        sent = run_on_hosts(two, ranks, folder, stack.enter_context(daemons(folder)))
    placed = ranks_by_host(two)
    figures.add(f"{ranks} ranks: fewest on one of the two hosts", min(placed.get(host, 0) for host in HOSTS), ranks / 2, least=True)
    figures.note("sent from the first host to the second [MB]", sent / 1e6)
    figures.add("places, velocities, temperatures of the particles against one host",
                difference(particles(one, step), particles(two, step)), 1e-12)
    budgets = [results.bed(run)["budget_error"][-1] for run in (one, two)]
    figures.add("energy not accounted for, of the exchange", max(map(abs, budgets)), 1e-8)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
