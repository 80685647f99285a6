# SPDX-License-Identifier: Apache-2.0
"""GDDR6, 14 Gb/s, one channel of 16 bits: 32 B in 2 clocks of 570 ps, 28.07 GB/s. One such memory stands behind each L2
slice. The export needs nothing but Python:

    PYTHONPATH=$RAMULATOR/python python3 -m ramulator export ramulator_gddr6.py -o gddr6.yaml
"""
import ramulator

controller = ramulator.controller.GenericDDR(
    dram=ramulator.dram.GDDR6(org_preset="GDDR6_8Gb_x16", timing_preset="GDDR6_14000_1350mV_quad"),
    scheduler=ramulator.scheduler.FRFCFS(),
    refresh_manager=ramulator.refresh_manager.AllBank(),
    row_policy=ramulator.row_policy.Open(),
    # Reads of one bank group are CCDL = 4 clocks apart, of different ones CCDS = 2: neighbouring addresses must lie in
    # different groups, or half of the bandwidth is lost.
    addr_mapper=ramulator.addr_mapper.MOP4CLXOR(),
    read_buffer_size=64,
    write_buffer_size=64,
)
memory = ramulator.memory_system.GenericDRAM(
    clock_ratio=1,
    controllers=[controller],
    channel_mapper=ramulator.channel_mapper.CacheLineInterleave(),
)
ramulator.Simulation(ramulator.frontend.External(clock_ratio=1), memory)
