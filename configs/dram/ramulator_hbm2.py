# SPDX-License-Identifier: Apache-2.0
"""HBM2, 2 Gb/s, one channel of two pseudo-channels of 64 bits: 32 GB/s. One such memory stands behind each L2 slice.

    PYTHONPATH=$RAMULATOR/python python3 -m ramulator export ramulator_hbm2.py -o hbm2.yaml
"""
import ramulator

controller = ramulator.controller.HBM12(
    dram=ramulator.dram.HBM2(org_preset="HBM2_4Gb", timing_preset="HBM2_2000Mbps"),
    scheduler=ramulator.scheduler.FRFCFSRowHit(),
    refresh_manager=ramulator.refresh_manager.AllBank(),
    row_policy=ramulator.row_policy.Open(),
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
