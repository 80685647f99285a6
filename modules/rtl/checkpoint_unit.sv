// Checkpoint unit of the RT unit: t-value validation, addresses of entries in two buffers that swap by round, combining
// writes, the queues of both directions. Pins and timing: docs/model/rtl_bridge.md. Paper: GRTX, Section IV-B.
// An item is an entry that a ray hands over, or the rest of its open sector. All channels move at the rising edge at
// which valid and ready are high; none of them waits for another's ready before it raises its valid.
module checkpoint_unit #(
    parameter LANES = 4,         // items an edge
    parameter WRITE_QUEUE = 16,  // sectors
    parameter RAYS = 256,        // warp buffer entries x 32
    parameter RAY_BITS = $clog2(RAYS),
    parameter LEVEL_BITS = $clog2(WRITE_QUEUE + 1),
    parameter PLACE_BITS = $clog2(WRITE_QUEUE)
) (
    input  logic                     clk,
    input  logic                     rst,                // synchronous; loads the bases and the size
    // Straps: constant while the unit works.
    input  logic [6:0]               cfg_lanes,          // 1 to LANES
    input  logic [LEVEL_BITS-1:0]    cfg_write_queue,    // 2 to WRITE_QUEUE
    input  logic                     cfg_write_combine,
    input  logic                     cfg_read_buffer,
    input  logic [4:0]               cfg_entry_bytes,    // 8, 16, 20 or 28
    input  logic [63:0]              cfg_base0,          // of buffer 0; buffers begin on 32 B
    input  logic [63:0]              cfg_base1,
    input  logic [15:0]              cfg_size,           // entries of a buffer
`ifdef CHECKPOINT_FAULTS
    input  logic [1:0]               fault,              // 1 comparison, 2 lost entry, 3 offset
`endif
    // A ray begins a round.
    input  logic                     begin_valid,
    output logic                     begin_ready,
    input  logic [RAY_BITS-1:0]      begin_ray,
    input  logic                     begin_replay,       // reads its source buffer
    // A ray hands over entries; last: it has no further event in its round.
    input  logic                     submit_valid,
    output logic                     submit_ready,
    input  logic [RAY_BITS-1:0]      submit_ray,
    input  logic [7:0]               submit_entries,
    input  logic                     submit_last,
    output logic                     submit_wait,        // it waits until item_done
    output logic                     submit_overflow,    // its buffer is too small: it restarts at the root
    output logic [15:0]              submit_end,         // entries of its round with these
    // Rays in the order of their submissions: whose items come next.
    output logic [LANES-1:0]         front_valid,
    output logic [LANES*RAY_BITS-1:0] front_ray,
    // Their items, in that order; a prefix of them is taken.
    input  logic [LANES-1:0]         item_valid,
    output logic [LANES-1:0]         item_ready,
    output logic [LANES-1:0]         item_done,          // the ray has handed over all
    output logic [LANES-1:0]         item_before,        // t < t_min
    output logic [LANES-1:0]         item_beyond,        // t_max < t
    output logic [LANES-1:0]         item_straddles,     // taken, and lies in two sectors
    input  logic [LANES*RAY_BITS-1:0] item_ray,
    input  logic [LANES-1:0]         item_parity,        // round mod 2: the buffer to write
    input  logic [LANES*48-1:0]      item_offset,        // of the ray's buffers, from the bases
    input  logic [LANES-1:0]         item_entry,         // an entry, else only the open sector
    input  logic [LANES-1:0]         item_end,           // the ray's last item of this submission
    input  logic [LANES-1:0]         item_last,          // and of its round
    input  logic [LANES*32-1:0]      item_t,
    input  logic [LANES*32-1:0]      item_t_min,
    input  logic [LANES*32-1:0]      item_t_max,
    input  logic [LANES*224-1:0]     item_data,
    // A ray reads its next source entry.
    input  logic                     read_valid,
    output logic                     read_ready,
    input  logic [RAY_BITS-1:0]      read_ray,
    output logic                     read_done,          // it is there: see part
    output logic                     read_refused,       // it does not replay, or has read all
    output logic                     read_straddles,
    // Where the buffers of the ray lie whose sectors are requested next.
    output logic [RAY_BITS-1:0]      look_ray,
    input  logic                     look_parity,
    input  logic [47:0]              look_offset,
    // To memory: one sector.
    output logic                     req_valid,
    input  logic                     req_ready,
    output logic                     req_write,
    output logic [47:0]              req_address,
    output logic [RAY_BITS:0]        req_tag,            // of a read: {second sector, ray}
    output logic [31:0]              req_mask,           // bytes to write
    output logic [255:0]             req_data,
    // From memory.
    input  logic                     rsp_valid,
    output logic                     rsp_ready,
    input  logic                     rsp_write,
    input  logic [RAY_BITS:0]        rsp_tag,
    input  logic [255:0]             rsp_data,
    // Bytes of a source entry, valid with the transfer of read or rsp that they come by.
    output logic                     part_valid,
    output logic                     part_done,          // with the entry's last bytes
    output logic [RAY_BITS-1:0]      part_ray,
    output logic [27:0]              part_mask,
    output logic [223:0]             part_data,
    // State.
    output logic [RAY_BITS:0]        submitted_level,
    output logic [RAY_BITS:0]        reads_level,
    output logic [LEVEL_BITS-1:0]    writes_level,
    output logic [15:0]              outstanding,
    output logic                     busy,
    output logic                     idle
);
`include "fp32.svh"
  // The paper's table: 33 bits a ray, two bases, one size.
  logic [15:0] source_offset [0:RAYS-1] /*verilator public_flat_rd*/;  // entries asked for
  logic [15:0] destination_offset [0:RAYS-1] /*verilator public_flat_rd*/;
  logic        replay_flag [0:RAYS-1];
  logic [63:0] base0, base1;
  logic [15:0] size;
  // The queues.
  logic [RAY_BITS-1:0] submitted [0:RAYS-1];
  logic [RAY_BITS-1:0] reads [0:RAYS-1];
  logic [47:0]  write_address [0:WRITE_QUEUE-1];
  logic [31:0]  write_mask [0:WRITE_QUEUE-1];
  logic [255:0] write_data [0:WRITE_QUEUE-1];
  // Switched on by straps.
  logic [255:0] open_sectors [0:RAYS-1];
  logic [255:0] read_sectors [0:RAYS-1];
  // Control.
  logic [RAY_BITS-1:0]   submitted_head /*verilator public_flat_rd*/, reads_head /*verilator public_flat_rd*/;
  logic [PLACE_BITS-1:0] write_head /*verilator public_flat_rd*/;
  logic                  first_sent /*verilator public_flat_rd*/;  // of the two sectors of the read at the front
  logic [RAYS-1:0]       halves;      // two responses missing
  logic [WRITE_QUEUE-1:0] queued;     // places that hold a sector

  logic wrong_comparison, loses_entry, wrong_offset;
`ifdef CHECKPOINT_FAULTS
  assign wrong_comparison = fault == 2'd1;
  assign loses_entry = fault == 2'd2;
  assign wrong_offset = fault == 2'd3;
`else
  assign {wrong_comparison, loses_entry, wrong_offset} = 3'd0;
`endif

  // First byte of entry n of a buffer: a multiplication by a constant, one adder at most.
  function [20:0] byte_of(input [15:0] n, input [4:0] entry_bytes);
    case (entry_bytes)
      5'd8: byte_of = {2'd0, n, 3'd0};
      5'd16: byte_of = {1'd0, n, 4'd0};
      5'd20: byte_of = {1'd0, n, 4'd0} + {3'd0, n, 2'd0};
      default: byte_of = {n, 5'd0} - {3'd0, n, 2'd0};
    endcase
  endfunction
  function [27:0] bytes_of_entry(input [4:0] entry_bytes);
    case (entry_bytes)
      5'd8: bytes_of_entry = 28'h00000ff;
      5'd16: bytes_of_entry = 28'h000ffff;
      5'd20: bytes_of_entry = 28'h00fffff;
      default: bytes_of_entry = 28'hfffffff;
    endcase
  endfunction
  function straddles_at(input [4:0] at, input [4:0] entry_bytes);
    straddles_at = {1'd0, at} + {1'd0, entry_bytes} > 6'd32;
  endfunction
  function [255:0] bits_of(input [31:0] mask);
    for (int i = 0; i < 32; i = i + 1) bits_of[i*8 +: 8] = {8{mask[i]}};
  endfunction
  // Bytes below `at` of a sector; at > 0.
  function [31:0] below(input [4:0] at);
    below = (32'd1 << at) - 32'd1;
  endfunction
  function [PLACE_BITS-1:0] place(input [PLACE_BITS-1:0] head, input [LEVEL_BITS:0] ahead,
                                  input [LEVEL_BITS-1:0] depth);
    logic [LEVEL_BITS:0] sum;
    sum = (LEVEL_BITS+1)'(head) + ahead;
    place = sum >= {1'b0, depth} ? PLACE_BITS'(sum - {1'b0, depth}) : PLACE_BITS'(sum);
  endfunction

  // --- Requests: reads first, unless the sector still waits to be written.
  logic [20:0] next_begin;
  logic next_held, next_straddles, next_second, next_waits, next_last;
  logic [63:0] next_address;
  assign look_ray = reads[reads_head];
  assign next_begin = byte_of(source_offset[look_ray] - 16'd1, cfg_entry_bytes);
  // The sector that ends with the entry before is held, so it needs no tag.
  assign next_held = cfg_read_buffer & next_begin[4:0] != 0;
  assign next_straddles = straddles_at(next_begin[4:0], cfg_entry_bytes);
  assign next_second = next_held | first_sent;
  assign next_last = next_second | ~next_straddles;
  assign next_address = (look_parity ? base0 : base1) + {16'd0, look_offset} +
                        {43'd0, next_begin[20:5], 5'd0} + (next_second ? 64'd32 : 64'd0);
  always_comb begin
    next_waits = 1'b0;
    for (int i = 0; i < WRITE_QUEUE; i = i + 1) begin
      if (queued[i] && write_address[i] == next_address[47:0]) next_waits = 1'b1;
    end
  end
  assign req_write = reads_level == 0 | next_waits;
  assign req_valid = ~req_write | writes_level != 0;
  assign req_address = req_write ? write_address[write_head] : next_address[47:0];
  assign req_tag = req_write ? '0 : {next_second, look_ray};
  assign req_mask = write_mask[write_head];
  assign req_data = write_data[write_head];
  logic requested, write_sent;
  assign requested = req_valid & req_ready;
  assign write_sent = requested & req_write;

  // --- Submissions.
  logic [15:0] submit_offset;
  logic [20:0] submit_begin;
  assign submit_offset = destination_offset[submit_ray];
  assign submit_begin = byte_of(submit_offset, cfg_entry_bytes);
  assign submit_end = submit_offset + {8'd0, submit_entries};
  assign submit_overflow = {1'b0, submit_offset} + {9'd0, submit_entries} > {1'b0, size};
  assign submit_wait = submit_entries != 0 | (submit_last & cfg_write_combine & submit_begin[4:0] != 0);
  assign submit_ready = 1'b1;  // a place for each ray
  assign begin_ready = 1'b1;
  logic submitting;
  assign submitting = submit_valid & submit_wait & ~submit_overflow;
  always_comb begin
    for (int i = 0; i < LANES; i = i + 1) begin
      front_valid[i] = (RAY_BITS+1)'(i) < submitted_level;
      front_ray[i*RAY_BITS +: RAY_BITS] = submitted[submitted_head + RAY_BITS'(i)];
    end
  end

  // --- t-value validation.
  genvar lane;
  generate
    for (lane = 0; lane < LANES; lane = lane + 1) begin : validation
      logic beyond;
      assign item_before[lane] = fp_less(item_t[lane*32 +: 32], item_t_min[lane*32 +: 32]);
      assign beyond = fp_less(item_t_max[lane*32 +: 32], item_t[lane*32 +: 32]);
      assign item_beyond[lane] = beyond | (wrong_comparison & item_t[lane*32 +: 32] == item_t_max[lane*32 +: 32]);
    end
  endgenerate

  // --- Items: a prefix of them, as far as cfg_lanes and the room in the write queue go.
  logic [LANES-1:0]      item_stored;              // an entry that is written
  logic [LANES*16-1:0]   new_offset;
  logic [LANES*256-1:0]  new_open;
  logic [2*LANES-1:0]    push;                     // two sectors an item at most
  logic [2*LANES*48-1:0] push_address;
  logic [2*LANES*32-1:0] push_mask;
  logic [2*LANES*256-1:0] push_data;
  logic [2*LANES*PLACE_BITS-1:0] push_place;
  logic [LEVEL_BITS:0]   pushes;
  logic [6:0]            rays_done;
  logic [LEVEL_BITS:0]   room;
  logic [6:0]            budget;
  logic                  walking, same, wide, complete, open_left;
  logic [RAY_BITS-1:0]   ray, previous;
  logic [15:0]           offset;
  logic [20:0]           first_byte, end_byte;
  logic [255:0]          opened, merged;
  logic [511:0]          placed;
  logic [63:0]           placed_mask;
  logic [63:0]           sector;
  always_comb begin
    // What leaves the queue at this edge makes room at this edge.
    room = {1'b0, cfg_write_queue} - {1'b0, writes_level} + {{LEVEL_BITS{1'b0}}, write_sent};
    budget = cfg_lanes;
    pushes = '0;
    rays_done = '0;
    walking = 1'b1;
    previous = '0;
    offset = '0;
    opened = '0;
    {ray, same, wide, complete, open_left, first_byte, end_byte, merged, placed, placed_mask, sector} = '0;
    for (int i = 0; i < LANES; i = i + 1) begin
      ray = item_ray[i*RAY_BITS +: RAY_BITS];
      same = i != 0 && ray == previous;
      if (!same) begin
        offset = destination_offset[ray];
        opened = open_sectors[ray];
      end
      previous = ray;
      first_byte = byte_of(offset, cfg_entry_bytes);
      wide = straddles_at(first_byte[4:0], cfg_entry_bytes);
      // One place for each sector that an item may complete.
      walking = walking & item_valid[i] & budget != 0 &
                room >= (~cfg_write_combine & item_entry[i] & cfg_entry_bytes[2] ? (LEVEL_BITS+1)'(2)
                                                                                 : (LEVEL_BITS+1)'(1));
      item_ready[i] = walking;
      item_stored[i] = item_entry[i] & item_beyond[i] & ~item_before[i];
      item_straddles[i] = walking & item_stored[i] & wide;
      placed = {288'd0, item_data[i*224 +: 224]} << {first_byte[4:0], 3'd0};
      placed_mask = {36'd0, bytes_of_entry(cfg_entry_bytes)} << first_byte[4:0];
      sector = (item_parity[i] ? base1 : base0) + {16'd0, item_offset[i*48 +: 48]} + {43'd0, first_byte[20:5], 5'd0};
      merged = (opened & bits_of(below(first_byte[4:0]))) | (placed[255:0] & bits_of(placed_mask[31:0]));
      complete = item_stored[i] & (wide | placed_mask[31]);
      push[2*i] = walking & item_stored[i] & (~cfg_write_combine | complete) & ~(loses_entry & offset == 16'd3);
      push_place[(2*i)*PLACE_BITS +: PLACE_BITS] = place(write_head, {1'b0, writes_level} + pushes, cfg_write_queue);
      push_address[(2*i)*48 +: 48] = sector[47:0];
      push_mask[(2*i)*32 +: 32] = cfg_write_combine ? 32'hffffffff : placed_mask[31:0];
      push_data[(2*i)*256 +: 256] = cfg_write_combine ? merged : placed[255:0];
      if (item_stored[i]) begin
        opened = complete ? placed[511:256] : merged;
        offset = offset + (wrong_offset & offset == 16'd3 ? 16'd2 : 16'd1);
      end
      new_offset[i*16 +: 16] = offset;
      new_open[i*256 +: 256] = opened;
      end_byte = byte_of(offset, cfg_entry_bytes);
      if (walking) begin
        budget = budget - 7'd1;
        room = room - {{LEVEL_BITS{1'b0}}, push[2*i]};
        pushes = pushes + {{LEVEL_BITS{1'b0}}, push[2*i]};
      end
      // The second sector: the other one of an entry, or what is open at the end of the round. A ray that hands over
      // nothing else has paid for it already.
      open_left = cfg_write_combine & item_end[i] & item_last[i] & end_byte[4:0] != 0;
      push[2*i+1] = walking & (cfg_write_combine
                                   ? open_left & (~item_entry[i] | (budget != 0 & room != 0))
                                   : item_stored[i] & wide);
      push_place[(2*i+1)*PLACE_BITS +: PLACE_BITS] = place(write_head, {1'b0, writes_level} + pushes, cfg_write_queue);
      push_address[(2*i+1)*48 +: 48] = sector[47:0] + (item_stored[i] & wide ? 48'd32 : 48'd0);
      push_mask[(2*i+1)*32 +: 32] = cfg_write_combine ? below(end_byte[4:0]) : placed_mask[63:32];
      push_data[(2*i+1)*256 +: 256] = cfg_write_combine ? opened : placed[511:256];
      if (push[2*i+1]) begin
        room = room - 1'b1;
        pushes = pushes + 1'b1;
        if (cfg_write_combine & item_entry[i]) budget = budget - 7'd1;
      end
      item_done[i] = walking & item_end[i] & (~open_left | push[2*i+1]);
      rays_done = rays_done + {6'd0, item_done[i]};
      walking = walking & (~item_end[i] | item_done[i]);
    end
  end

  // --- Reading.
  logic [15:0] read_offset;
  logic [20:0] read_begin, part_begin;
  logic read_held, reading;
  assign read_offset = source_offset[read_ray];
  assign read_begin = byte_of(read_offset, cfg_entry_bytes);
  assign read_held = cfg_read_buffer & read_begin[4:0] != 0;
  assign read_straddles = straddles_at(read_begin[4:0], cfg_entry_bytes);
  assign read_refused = ~replay_flag[read_ray] | read_offset >= size;
  assign read_done = read_held & ~read_straddles & ~read_refused;
  assign read_ready = ~rsp_valid;  // parts have one way out
  assign rsp_ready = 1'b1;
  assign reading = read_valid & read_ready & ~read_refused;
  // Parts: of a sector that has come, of the one that the ray holds, or of both.
  logic arrived, part_straddles, part_held, second;
  logic [255:0] held;
  logic [511:0] window;
  logic [63:0] known;
  assign arrived = rsp_valid & ~rsp_write;
  assign second = rsp_tag[RAY_BITS];
  assign part_ray = rsp_valid ? rsp_tag[RAY_BITS-1:0] : read_ray;
  assign part_begin = rsp_valid ? byte_of(source_offset[part_ray] - 16'd1, cfg_entry_bytes) : read_begin;
  assign part_straddles = straddles_at(part_begin[4:0], cfg_entry_bytes);
  assign part_held = cfg_read_buffer & part_begin[4:0] != 0;
  assign held = cfg_read_buffer ? read_sectors[part_ray] : '0;
  assign window = {rsp_data, arrived & ~second ? rsp_data : held};
  assign known = {{32{arrived & second}}, {32{(arrived & ~second) | part_held}}};
  assign part_data = 224'(window >> {part_begin[4:0], 3'd0});
  assign part_mask = 28'(known >> part_begin[4:0]) & bytes_of_entry(cfg_entry_bytes);
  assign part_valid = arrived | (reading & read_done);
  assign part_done = arrived ? ~halves[part_ray] : read_done;

  assign busy = submitted_level != 0 | reads_level != 0 | writes_level != 0;
  assign idle = ~busy & outstanding == 0;

  always_ff @(posedge clk) begin
    if (rst) begin
      base0 <= cfg_base0;
      base1 <= cfg_base1;
      size <= cfg_size;
      submitted_head <= '0;
      submitted_level <= '0;
      reads_head <= '0;
      reads_level <= '0;
      write_head <= '0;
      writes_level <= '0;
      queued <= '0;
      first_sent <= 1'b0;
      halves <= '0;
      outstanding <= '0;
    end else begin
      submitted_head <= submitted_head + RAY_BITS'(rays_done);
      submitted_level <= submitted_level + {{RAY_BITS{1'b0}}, submitting} - (RAY_BITS+1)'(rays_done);
      if (requested & ~req_write) begin
        first_sent <= ~next_last;
        if (next_last) reads_head <= reads_head + 1'b1;
      end
      reads_level <= reads_level + {{RAY_BITS{1'b0}}, reading & ~read_done} -
                     {{RAY_BITS{1'b0}}, requested & ~req_write & next_last};
      if (write_sent) begin
        write_head <= place(write_head, 1, cfg_write_queue);
        queued[write_head] <= 1'b0;
      end
      writes_level <= LEVEL_BITS'({1'b0, writes_level} + pushes - {{LEVEL_BITS{1'b0}}, write_sent});
      for (int i = 0; i < 2 * LANES; i = i + 1) begin
        if (push[i]) queued[push_place[i*PLACE_BITS +: PLACE_BITS]] <= 1'b1;
      end
      if (reading & ~read_done) halves[read_ray] <= read_straddles & ~read_held;
      if (arrived & halves[part_ray]) halves[part_ray] <= 1'b0;
      outstanding <= outstanding + {15'd0, requested} - {15'd0, rsp_valid};
    end
  end

  // What reset leaves as it is.
  always_ff @(posedge clk) begin
    if (begin_valid) begin
      source_offset[begin_ray] <= 16'd0;
      destination_offset[begin_ray] <= 16'd0;
      replay_flag[begin_ray] <= begin_replay;
    end
    if (submit_valid & submit_overflow) replay_flag[submit_ray] <= 1'b0;
    if (submitting) submitted[submitted_head + submitted_level[RAY_BITS-1:0]] <= submit_ray;
    if (reading) source_offset[read_ray] <= read_offset + 16'd1;
    if (reading & ~read_done) reads[reads_head + reads_level[RAY_BITS-1:0]] <= read_ray;
    // When a ray has several items, the last one counts.
    for (int i = 0; i < LANES; i = i + 1) begin
      if (item_ready[i]) begin
        destination_offset[item_ray[i*RAY_BITS +: RAY_BITS]] <= new_offset[i*16 +: 16];
        if (cfg_write_combine) open_sectors[item_ray[i*RAY_BITS +: RAY_BITS]] <= new_open[i*256 +: 256];
      end
    end
    for (int i = 0; i < 2 * LANES; i = i + 1) begin
      if (push[i]) begin
        write_address[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_address[i*48 +: 48];
        write_mask[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_mask[i*32 +: 32];
        write_data[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_data[i*256 +: 256];
      end
    end
    if (cfg_read_buffer & arrived & (second | ~part_straddles)) read_sectors[part_ray] <= rsp_data;
  end
endmodule
