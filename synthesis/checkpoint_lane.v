// The arithmetic of one checkpoint lane, as modules/rt_unit/checkpoint_unit.cpp counts it: t_hit against t_min and t_max, source
// and destination address = base + slot offset + 20 x entry, both entry numbers incremented and held against the
// buffer's size. A ray's slot lies within 4 GiB of the base (the paper's largest buffers have 2.03 GiB).
module checkpoint_lane(input [31:0] t_hit, input [31:0] t_min, input [31:0] t_max, input [63:0] source_base,
                       input [63:0] destination_base, input [31:0] slot, input [15:0] source_entry,
                       input [15:0] destination_entry, input [15:0] size, output before, output beyond,
                       output [63:0] source, output [63:0] destination, output [15:0] next_source,
                       output [15:0] next_destination, output source_left, output destination_room);
  fp_less at_begin(.a(t_hit), .b(t_min), .y(before));
  fp_less at_end(.a(t_max), .b(t_hit), .y(beyond));
  // x 20 = x 16 + x 4: one adder.
  wire [31:0] source_offset = slot + ({source_entry, 4'd0} + {source_entry, 2'd0});
  wire [31:0] destination_offset = slot + ({destination_entry, 4'd0} + {destination_entry, 2'd0});
  assign source = source_base + source_offset;
  assign destination = destination_base + destination_offset;
  assign next_source = source_entry + 16'd1;
  assign next_destination = destination_entry + 16'd1;
  assign source_left = source_entry < size;
  assign destination_room = destination_entry < size;
endmodule
